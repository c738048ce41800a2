// SPDX-License-Identifier: MIT
#include "trainer/data/log_outliers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "trainer/base/quantile.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The usual range of a state over all logs, robust against a few outliers.
struct Usual {
  double low = 0.0, high = 0.0;  ///< limits by the quantiles of 1 % and 99 %, and by five deviations from the median
  double step = 0.0;             ///< ten times the median of the steps that are not 0

  bool has(double value) const { return value >= low && value <= high; }
};

Usual usual_of(const std::vector<VectorXd>& signals) {
  // Ratio of the standard deviation of a normal distribution to its median absolute deviation.
  constexpr double kDeviation = 1.4826;
  std::vector<double> values, steps;
  for (const VectorXd& x : signals) {
    values.insert(values.end(), x.begin(), x.end());
    for (Index k = 1; k < x.size(); ++k)
      if (x[k] != x[k - 1]) steps.push_back(std::abs(x[k] - x[k - 1]));
  }
  Usual usual;
  if (steps.empty()) return usual;
  const double low = value_at_rank_of(values, 0.01), high = value_at_rank_of(values, 0.99),
               median = value_at_rank_of(values, 0.5);
  for (double& value : values) value = std::abs(value - median);
  const double deviation = kDeviation * value_at_rank_of(values, 0.5);
  usual.low = std::min(low - (high - low), median - 5.0 * deviation);
  usual.high = std::max(high + (high - low), median + 5.0 * deviation);
  usual.step = 10.0 * value_at_rank_of(steps, 0.5);
  return usual;
}

/// Returns true if rows [from, to) leave the usual range by a step and return after it. At an end of the log one of the
/// steps is enough.
bool is_outlier(const VectorXd& x, Index from, Index to, const Usual& usual) {
  const auto jumps = [&](Index a, Index b) { return std::abs(x[a] - x[b]) > usual.step; };
  if (to - from > kOutlierRows || to - from == x.size()) return false;
  return (from == 0 || jumps(from, from - 1)) && (to == x.size() || jumps(to - 1, to));
}

}  // namespace

void note_outliers(const LogSchema& schema, const std::vector<LogFile>& logs, std::vector<std::string>& notes) {
  std::set<std::string> seen;
  for (const LogColumn& state : schema.states) {
    if (logs.empty() || !seen.insert(state.heading).second) continue;
    std::vector<VectorXd> signals;
    for (const LogFile& log : logs) {
      signals.push_back(log.values(state));
      if (state.wrap > 0.0) signals.back() = unwrap(signals.back(), state.wrap);
    }
    const Usual usual = usual_of(signals);
    if (!(usual.low < usual.high)) continue;
    Index rows = 0, row = 0;
    double farthest = 0.0;
    const LogFile* where = nullptr;
    const VectorXd* signal = nullptr;
    for (std::size_t i = 0; i < logs.size(); ++i) {
      const VectorXd& x = signals[i];
      for (Index from = 0, to = 0; from < x.size(); from = std::max(to, from + 1)) {
        for (to = from; to < x.size() && !usual.has(x[to]);) ++to;
        if (to == from || !is_outlier(x, from, to, usual)) continue;
        rows += to - from;
        for (Index k = from; k < to; ++k) {
          const double beyond = std::max(usual.low - x[k], x[k] - usual.high);
          if (where != nullptr && beyond <= farthest) continue;
          farthest = beyond, row = k, where = &logs[i], signal = &x;
        }
      }
    }
    if (where == nullptr) continue;
    Index before = row, after = row;
    while (before > 0 && !usual.has((*signal)[before])) --before;
    while (after + 1 < signal->size() && !usual.has((*signal)[after])) ++after;
    const std::string unit = state.unit.empty() || state.derivative ? "" : " " + state.unit;
    notes.push_back(fmt::format(
        "{}:{}: \"{}\" is {:.4g}{}, but {:.4g} before and {:.4g} after{}: an outlier, which an observer would learn as "
        "truth; correct it, or leave the cell empty, so that the row is not scored",
        where->name, where->lines[static_cast<std::size_t>(row)], state.heading, (*signal)[row], unit,
        (*signal)[before], (*signal)[after], rows == 1 ? "" : fmt::format(" (the farthest of {} such rows)", rows)));
  }
}

}  // namespace nlo::trainer
