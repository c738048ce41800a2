// SPDX-License-Identifier: MIT
#include "trainer/compare/filter_search.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "trainer/evaluation/text.h"
#include "trainer/identify/filter_tuning.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kNoGate = 1e2;  // standard deviations: nothing of a run is beyond
constexpr double kUsualGate = 3.5;
constexpr double kWidest = 12.0;  // decades: further from what is shipped no filter is one

FilterTuning tuning_of(const FilterRow& row, const VectorXd& x) {
  FilterTuning tuning;
  const auto coordinates = static_cast<Index>(row.coordinates.size());
  for (Index i = 0; i < coordinates; ++i)
    tuning.*row.coordinates[static_cast<std::size_t>(i)] = std::pow(10.0, std::clamp(x[i], -kWidest, kWidest));
  if (row.has_gate && std::pow(10.0, x[coordinates]) < kNoGate)
    tuning.gate = std::pow(10.0, std::max(x[coordinates], -1.0));
  return tuning;
}

/// What a search starts from: all of Q x 1, 100, 1e4, R x .1, 1, 10, with a gate and without.
std::vector<VectorXd> grid(const FilterRow& row) {
  const auto coordinates = static_cast<Index>(row.coordinates.size());
  std::vector<VectorXd> points{VectorXd::Zero(coordinates + (row.has_gate ? 1 : 0))};
  if (row.has_gate) points.front()[coordinates] = std::log10(kNoGate);
  const auto spread = [&](Index coordinate, const std::vector<double>& values) {
    std::vector<VectorXd> all;
    for (const VectorXd& point : points)
      for (const double value : values) {
        all.push_back(point);
        all.back()[coordinate] = value;
      }
    points = std::move(all);
  };
  for (Index i = 0; i < coordinates; ++i) {
    if (row.coordinates[static_cast<std::size_t>(i)] == &FilterTuning::process) spread(i, {0.0, 2.0, 4.0});
    if (row.coordinates[static_cast<std::size_t>(i)] == &FilterTuning::output) spread(i, {0.0, -1.0, 1.0});
  }
  if (row.has_gate) spread(coordinates, {std::log10(kNoGate), std::log10(kUsualGate)});
  return points;
}

}  // namespace

TunedFilter tune_filter(const FilterRow& row, const FilterContext& context, const ComparedRuns& runs,
                        const std::atomic<bool>* stop) {
  TunedFilter result;
  const CostsOf costs = [&](const std::vector<VectorXd>& points) {
    std::vector<FilterTuning> tunings;
    for (const VectorXd& point : points) tunings.push_back(tuning_of(row, point));
    const auto count = static_cast<Index>(points.size());
    const LaneRuns lanes = repeated(runs.measured, count);
    const auto filter = row.make(context, tunings, lanes.lanes());
    const Eigen::ArrayXd squares = squared_errors(*filter, lanes, runs);
    std::vector<double> norms;
    const Index each = squares.size() / count;
    for (Index t = 0; t < count; ++t) norms.push_back(std::sqrt(squares.segment(t * each, each).mean()));
    result.evaluations += static_cast<int>(count);
    return norms;
  };
  const std::vector<VectorXd> points = grid(row);
  const std::vector<double> found = costs(points);
  std::size_t best = 0;
  for (std::size_t i = 1; i < found.size(); ++i)
    if (found[i] < found[best]) best = i;
  const int most_sweeps = std::max(1, row.most_evaluations / (4 * static_cast<int>(points[best].size())));
  const Tuned tuned = coordinate_search(points[best], costs, true, stop, most_sweeps);
  result.tuning = tuning_of(row, tuned.x);
  result.norm = tuned.cost;
  return result;
}

std::string describe_tuning(const FilterRow& row, const FilterTuning& tuning) {
  std::string text;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto coordinate : row.coordinates) {
    if (tuning.*coordinate == 1.0) continue;
    const char* name = coordinate == &FilterTuning::process ? "Q" : coordinate == &FilterTuning::output ? "R" : "P0";
    add(fmt::format("{} x {}", name, significant(tuning.*coordinate, 2)));
  }
  if (std::isfinite(tuning.gate)) add("gate " + significant(tuning.gate, 2));
  return text.empty() ? "as shipped" : text;
}

}  // namespace nlo::trainer
