// SPDX-License-Identifier: MIT
#include "trainer/replay/flight_times.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace nlo::trainer {

using Eigen::Index;

Eigen::VectorXd seconds_between(const Eigen::VectorXd& time, const Eigen::VectorXd& stepped_s) {
  constexpr std::size_t kFewest = 8;
  Eigen::VectorXd since = Eigen::VectorXd::Constant(time.size(), std::numeric_limits<double>::quiet_NaN());
  std::vector<double> units;  // of the stamps in a second, by each row
  for (Index row = 1; row < time.size(); ++row) {
    since[row] = time[row] - time[row - 1];
    if (std::isfinite(since[row]) && stepped_s[row] > 0.0) units.push_back(since[row] / stepped_s[row]);
  }
  if (units.size() < kFewest) return {};
  std::nth_element(units.begin(), units.begin() + static_cast<std::ptrdiff_t>(units.size() / 2), units.end());
  double unit = units[units.size() / 2];
  constexpr double kNear = 0.2, kFollows = 0.25, kMost = 0.8;
  for (const double known : {1.0, 1e3, 1e6, 1e9})
    if (std::abs(unit / known - 1.0) < kNear) unit = known;
  const auto following =
      std::count_if(units.begin(), units.end(), [&](double each) { return std::abs(each / unit - 1.0) < kFollows; });
  if (!(unit > 0.0) || static_cast<double>(following) < kMost * static_cast<double>(units.size())) return {};
  since /= unit;
  since[0] = stepped_s[0];
  return since;
}

namespace {

constexpr double kOff = 0.25;  // of a sample period: more than jitter

}  // namespace

StepTimes::StepTimes(const FlightLog& log, double sample_period_s, Index right)
    : log_(log), period_s_(sample_period_s), off_(kOff) {
  constexpr Index kSeveral = 8;
  constexpr double kTimes = 2.0, kLeast = 1e-4;
  double jitter = 0.0;
  for (Index row = 1; row < right; ++row)
    if (const double now = std::abs(beyond(row)); now < kOff) jitter = std::max(jitter, now);
  if (right > kSeveral) off_ = std::clamp(kTimes * jitter, kLeast, kOff);
}

/// Sample periods that the time goes on by before this row, beyond what was stepped over.
double StepTimes::beyond(Index row) const {
  if (log_.since_s.size() == 0) return 0.0;
  const bool over_dt = log_.given(kGivenCommand, row) == kStepOverDt;
  return (log_.since_s[row] - (over_dt ? log_.given(kGivenDt, row) : period_s_)) / period_s_;
}

bool StepTimes::off(Index row) const {
  return std::abs(beyond(row)) > off_;
}

Index StepTimes::lost(Index row) const {
  const double whole = std::round(beyond(row));
  return whole >= 1.0 && std::abs(beyond(row) - whole) < kOff ? static_cast<Index>(whole) : 0;
}

Index StepTimes::passed(Index row) const {
  return static_cast<Index>(std::lround(log_.since_s[row] / period_s_));
}

}  // namespace nlo::trainer
