// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/metrics.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "codegen/base/error.h"
#include "trainer/data/evaluation_windows.h"
#include "trainer/data/log_baselines.h"
#include "trainer/data/transient.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {
namespace {

using codegen::Error;

/// Returns the first time from which every full window has an error of at most `limit`; nothing if the last window does
/// not.
std::optional<double> settling_time(const Eigen::VectorXd& time_s, const Eigen::VectorXd& curve, double limit,
                                    double window_s) {
  const Eigen::Index n = time_s.size();
  if (n == 0) return std::nullopt;
  // Searches backward with a sliding window: `end` is the first instant outside [time_s[k], time_s[k] + window_s).
  std::optional<double> settled_since;
  // The windows at the end would be shorter and too noisy.
  const double last_start_s = std::max(time_s[0], time_s[n - 1] - window_s);
  Eigen::Index end = n;
  for (Eigen::Index k = n - 1; k >= 0; --k) {
    if (time_s[k] > last_start_s) continue;
    while (end - 1 > k && time_s[end - 1] >= time_s[k] + window_s) --end;
    const double rms = std::sqrt(curve.segment(k, end - k).squaredNorm() / static_cast<double>(end - k));
    if (rms > limit) break;
    settled_since = time_s[k];
  }
  return settled_since;
}

}  // namespace

double wrapped_difference(double truth, double estimate, double wrap) {
  const double difference = truth - estimate;
  return wrap > 0.0 ? std::remainder(difference, wrap) : difference;
}

bool share_a_unit(const std::vector<Channel>& states) {
  return std::all_of(states.begin(), states.end(),
                     [&](const Channel& state) { return state.unit == states.front().unit; });
}

Eigen::VectorXd state_deviation(const Dataset& dataset) {
  const Eigen::VectorXd mean = mean_states(dataset);
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(mean.size());
  double weight = 0.0;
  for (const Trajectory& run : dataset.trajectories) {
    weight += run.weight.sum();
    for (Eigen::Index i = 0; i < mean.size(); ++i) {
      const double wrap = dataset.states[static_cast<std::size_t>(i)].wrap;
      for (Eigen::Index k = 0; k < run.samples(); ++k) {
        if (run.weight[k] <= 0.0) continue;  // masked truth may have any value
        const double value = wrapped_difference(run.states(i, k), mean[i], wrap);
        squares[i] += run.weight[k] * value * value;
      }
    }
  }
  for (double& square : squares) square = square > 0.0 ? std::sqrt(square / weight) : 1.0;
  return squares;
}

ErrorAccumulator::ErrorAccumulator(std::vector<Channel> states, double sample_period_s, const MetricsConfig& config)
    : states_(std::move(states)), sample_period_s_(sample_period_s), config_(config) {
  const auto nx = static_cast<Eigen::Index>(states_.size());
  const auto windows = static_cast<Eigen::Index>(config_.windows.size());
  squared_error_ = Eigen::MatrixXd::Zero(nx, windows);
  weight_ = Eigen::VectorXd::Zero(windows);
  inverse_square_scale_ = Eigen::VectorXd::Ones(nx);
  if (config_.state_scale.size() > 0) inverse_square_scale_ = config_.state_scale.cwiseAbs2().cwiseInverse();
  if (!(sample_period_s > 0.0)) throw Error("error metrics: the data set has no sample period (it must be positive)");
}

double ErrorAccumulator::add(const Trajectory& truth, const Eigen::MatrixXd& estimate) {
  const Eigen::Index nx = squared_error_.rows(), n = truth.samples();
  if (truth.states.rows() != nx || truth.states.cols() != n || truth.weight.size() != n)
    throw Error("error metrics: " + truth.source + ": states and weight do not match the time stamps");
  if (estimate.rows() != nx || estimate.cols() != n)
    throw Error("error metrics: " + truth.source + ": the estimate is " + std::to_string(estimate.rows()) + " x " +
                std::to_string(estimate.cols()) + ", the truth " + std::to_string(nx) + " x " + std::to_string(n));

  // Tolerance of half a sample: 10 s accumulated in steps of 0.02 s may give 9.99999...
  const double slack_s = 0.5 * sample_period_s_;
  // Sums each run separately first, which reduces rounding errors.
  Eigen::MatrixXd run = Eigen::MatrixXd::Zero(nx, squared_error_.cols());
  Eigen::VectorXd squares(nx);
  double run_truth = 0.0, run_weight = 0.0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double weight = truth.weight[k];
    if (weight <= 0.0) continue;
    for (Eigen::Index i = 0; i < nx; ++i) {
      const double wrap = states_[static_cast<std::size_t>(i)].wrap;
      const double error = wrapped_difference(truth.states(i, k), estimate(i, k), wrap);
      if (!std::isfinite(error))
        throw Error("error metrics: " + truth.source + ": truth or estimate of " +
                    states_[static_cast<std::size_t>(i)].name + " is not finite at sample " + std::to_string(k));
      const double value = wrapped_difference(truth.states(i, k), 0.0, wrap);
      squares[i] = error * error;
      run_truth += weight * value * value;
    }
    for (std::size_t w = 0; w < config_.windows.size(); ++w) {
      const double t = truth.time_s[k] + slack_s;
      if (w > 0 && (t < config_.windows[w].from_s || t >= config_.windows[w].to_s)) continue;
      if (w == 0) run_weight += weight;
      run.col(static_cast<Eigen::Index>(w)) += weight * squares;
      weight_[static_cast<Eigen::Index>(w)] += weight;
    }
    const auto tick = static_cast<std::size_t>(std::max(0LL, std::llround(truth.time_s[k] / sample_period_s_)));
    if (tick >= instants_.size()) instants_.resize(tick + 1);
    instants_[tick].squared_error += weight * squares.dot(inverse_square_scale_);
    instants_[tick].weight += weight;
    ++samples_;
  }
  squared_error_ += run;
  squared_truth_ += run_truth;
  return norm_of(run.col(0), run_weight);
}

void ErrorAccumulator::merge(const ErrorAccumulator& other) {
  if (other.squared_error_.rows() != squared_error_.rows() || other.squared_error_.cols() != squared_error_.cols() ||
      other.sample_period_s_ != sample_period_s_)
    throw Error("error metrics: only sums over the same states, windows and sample period can be joined");
  squared_error_ += other.squared_error_;
  squared_truth_ += other.squared_truth_;
  weight_ += other.weight_;
  samples_ += other.samples_;
  if (other.instants_.size() > instants_.size()) instants_.resize(other.instants_.size());
  for (std::size_t k = 0; k < other.instants_.size(); ++k) {
    instants_[k].squared_error += other.instants_[k].squared_error;
    instants_[k].weight += other.instants_[k].weight;
  }
}

double ErrorAccumulator::norm_of(const Eigen::VectorXd& squared_error, double weight) const {
  return std::sqrt(squared_error.dot(inverse_square_scale_) / weight);
}

ErrorMetrics ErrorAccumulator::metrics() const {
  if (samples_ == 0)
    throw Error(
        "error metrics: there is no sample with a known truth (no trajectory, or all truth is masked); unmask some "
        "samples");
  ErrorMetrics result;
  result.samples = samples_;
  result.normalised = config_.state_scale.size() > 0;
  for (std::size_t w = 0; w < config_.windows.size(); ++w) {
    const auto column = static_cast<Eigen::Index>(w);
    ErrorMetrics::Window& window = result.windows.emplace_back();
    window.window = config_.windows[w];
    if (weight_[column] <= 0.0) continue;
    window.norm = norm_of(squared_error_.col(column), weight_[column]);
    window.per_component = (squared_error_.col(column) / weight_[column]).cwiseSqrt();
  }
  result.norm = *result.windows.front().norm;
  result.per_component = result.windows.front().per_component;
  if (result.normalised)
    result.nrmse = result.norm / std::sqrt(static_cast<double>(states_.size()));
  else if (squared_truth_ > 0.0)
    result.nrmse = result.norm / std::sqrt(squared_truth_ / weight_[0]);

  const auto known = std::count_if(instants_.begin(), instants_.end(), [](const Instant& i) { return i.weight > 0.0; });
  result.curve_time_s.resize(known);
  result.curve.resize(known);
  Eigen::Index next = 0;
  for (std::size_t k = 0; k < instants_.size(); ++k) {
    if (instants_[k].weight <= 0.0) continue;
    result.curve_time_s[next] = static_cast<double>(k) * sample_period_s_;
    result.curve[next++] = std::sqrt(instants_[k].squared_error / instants_[k].weight);
  }
  if (const std::size_t settled = settled_window(config_.windows); settled > 0 && result.windows[settled].norm) {
    result.settled = result.windows[settled].norm;
    result.settled_per_component = result.windows[settled].per_component;
    result.settling_time_s = settling_time(result.curve_time_s, result.curve, config_.settling_ratio * *result.settled,
                                           config_.settling_window_s);
  }
  return result;
}

MetricsConfig metrics_config(const Experiment& experiment, double horizon_s) {
  MetricsConfig config;
  config.windows = windows_of(experiment, horizon_s);
  config.settling_window_s = settling_window_s(experiment.evaluation, config.windows, horizon_s);
  return config;
}

MetricsConfig metrics_config(const Experiment& experiment, const Dataset& logs) {
  return metrics_config(experiment, logs.longest_s());
}

}  // namespace nlo::trainer
