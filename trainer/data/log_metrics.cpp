// SPDX-License-Identifier: MIT
#include "trainer/data/log_metrics.h"

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <numbers>

#include "codegen/base/error.h"
#include "trainer/data/angle.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::RowVectorXd;

struct Sums {
  explicit Sums(std::size_t windows) : squares(windows), weights(windows) {}

  void add(const Trajectory& run, const RowVectorXd& error, const EvaluationWindows& windows) {
    for (Index k = 0; k < run.samples(); ++k) {
      if (run.weight[k] == 0.0) continue;  // masked truth may have any value
      for (std::size_t w = 0; w < windows.size(); ++w) {
        if (run.time_s[k] < windows[w].from_s || run.time_s[k] >= windows[w].to_s) continue;
        squares[w] += run.weight[k] * error[k] * error[k];
        weights[w] += run.weight[k];
      }
    }
  }

  void add(const Sums& other) {
    for (std::size_t w = 0; w < squares.size(); ++w) {
      squares[w] += other.squares[w];
      weights[w] += other.weights[w];
    }
  }

  /// Without weight the result is 0/0, NaN: nothing was measured.
  StateError finish(const std::string& name, const std::string& unit) const {
    StateError result{name, unit, {}};
    for (std::size_t w = 0; w < squares.size(); ++w) result.rmse.push_back(std::sqrt(squares[w] / weights[w]));
    return result;
  }

  std::vector<double> squares, weights;  ///< per window
};

RowVectorXd wrapped(RowVectorXd error, double wrap) {
  if (wrap > 0.0)
    for (double& e : error) e = std::isfinite(e) ? wrap_difference(e, wrap) : e;
  return error;
}

/// Returns the angles between vectors, accurate to rounding at any angle (Kahan).
RowVectorXd between_directions(const MatrixXd& estimate, const MatrixXd& truth, Index first) {
  const MatrixXd a = estimate.middleRows<3>(first).colwise().normalized(),
                 b = truth.middleRows<3>(first).colwise().normalized();
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  return 2.0 * kDegrees * (a - b).colwise().norm().binaryExpr((a + b).colwise().norm(), [](double y, double x) {
    return std::atan2(y, x);
  });
}

RowVectorXd angle_row(const MatrixXd& states, const AnglePair& pair) {
  return angle_of(states.row(pair.sine).transpose(), states.row(pair.sine + 1).transpose(), pair.wrap).transpose();
}

std::vector<Sums> sums_of(const Dataset& data, const Trajectory& run, const MatrixXd& estimate,
                          const std::vector<AnglePair>& angle_pairs, const EvaluationWindows& windows) {
  std::vector<Sums> sums(data.states.size() + angle_pairs.size(), Sums(windows.size()));
  std::size_t next = 0;
  for (std::size_t i = 0; i < data.states.size(); ++i) {
    const auto row = static_cast<Index>(i);
    sums[next++].add(run, wrapped(estimate.row(row) - run.states.row(row), data.states[i].wrap), windows);
  }
  for (const AnglePair& pair : angle_pairs)
    sums[next++].add(run,
                     pair.components == 3 ? between_directions(estimate, run.states, pair.sine)
                                          : wrapped(angle_row(estimate, pair) - angle_row(run.states, pair), pair.wrap),
                     windows);
  return sums;
}

std::vector<StateError> finish(const Dataset& data, const std::vector<AnglePair>& angle_pairs,
                               const std::vector<Sums>& sums) {
  std::vector<StateError> errors;
  std::size_t next = 0;
  for (const Channel& state : data.states) errors.push_back(sums[next++].finish(state.name, state.unit));
  for (const AnglePair& pair : angle_pairs) errors.push_back(sums[next++].finish(pair.name, pair.unit));
  return errors;
}

}  // namespace

LogMetrics log_metrics(const Dataset& data, const std::vector<MatrixXd>& estimates,
                       const std::vector<AnglePair>& angle_pairs, const EvaluationWindows& windows) {
  if (estimates.size() != data.trajectories.size())
    throw codegen::Error(
        fmt::format("log metrics: estimates of {} logs for {} logs", estimates.size(), data.trajectories.size()));
  LogMetrics metrics{windows, {}, estimates.size(), {}};
  const std::vector<Sums> none(data.states.size() + angle_pairs.size(), Sums(windows.size()));
  std::vector<Sums> pooled = none, log = none;
  std::size_t runs = 0;  // number of runs of this log
  for (std::size_t file = 0; file < estimates.size(); ++file) {
    const Trajectory& run = data.trajectories[file];
    if (estimates[file].rows() != run.states.rows() || estimates[file].cols() != run.samples())
      throw codegen::Error(fmt::format("log metrics: {}: an estimate of {} x {} for states of {} x {}", run.source,
                                       estimates[file].rows(), estimates[file].cols(), run.states.rows(),
                                       run.samples()));
    const std::vector<Sums> sums = sums_of(data, run, estimates[file], angle_pairs, windows);
    for (std::size_t i = 0; i < sums.size(); ++i) pooled[i].add(sums[i]), log[i].add(sums[i]);
    ++runs;
    if (file + 1 < estimates.size() && !run.log.empty() && data.trajectories[file + 1].log == run.log) continue;
    const std::string name = std::filesystem::path(run.log).filename().string();
    metrics.files.push_back(
        {runs == 1 ? run.source : fmt::format("{} ({} runs)", name, runs), finish(data, angle_pairs, log)});
    log = none;
    runs = 0;
  }
  metrics.pooled = finish(data, angle_pairs, pooled);
  return metrics;
}

}  // namespace nlo::trainer
