// SPDX-License-Identifier: MIT
// Error metrics of the strict test, accumulated trajectory by trajectory, so that a large test need not be in memory.
// Also returns the configuration of the metrics for an experiment.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/data/evaluation_windows.h"

namespace nlo::trainer {

/// Configuration of the metrics.
///
/// Settling time: the first t from which the error averaged over the trajectories and over [t, t + settling_window_s)
/// (root mean square) stays within `settling_ratio` times the error in the settled window for the rest of the run.
struct MetricsConfig {
  EvaluationWindows windows = whole_run();  ///< "all" first
  double settling_ratio = 1.5;
  double settling_window_s = 1.0;
  /// n_x: scale of each state in norms, if the units of the states differ (state_deviation()); empty: norms are
  /// physical.
  Eigen::VectorXd state_scale = {};
};

/// Error metrics. Every number is finite; a number is missing if a run is too short or too quiet to define it.
struct ErrorMetrics {
  /// Errors over the samples in one window.
  struct Window {
    EvaluationWindow window;
    std::optional<double> norm;
    Eigen::VectorXd per_component;  ///< n_x, RMSE of each state in its unit; size 0 when no sample counts
  };

  bool normalised = false;        ///< norms use states divided by their deviation: a constant estimate gives sqrt(n_x)
  double norm = 0.0;              ///< sqrt(mean of |x - x_hat|^2) over trajectories and samples, transient included
  std::optional<double> nrmse;    ///< norm / RMS|x|; if normalised: norm / sqrt(n_x); missing if the truth is zero
  std::optional<double> settled;  ///< norm in the settled window; empty without one, or without a sample in it
  Eigen::VectorXd per_component;  ///< RMSE of each state in its unit, n_x
  Eigen::VectorXd settled_per_component;  ///< RMSE of each state in the settled window, n_x; size 0 without `settled`
  std::vector<Window> windows;            ///< as configured, "all" first
  std::optional<double> settling_time_s;  ///< see MetricsConfig; missing if the error never settles
  Eigen::VectorXd curve_time_s;           ///< error versus time, one entry per sample instant
  Eigen::VectorXd curve;                  ///< the norm over the trajectories at that instant
  std::int64_t samples = 0;               ///< number of samples that count (weight > 0)
};

/// Returns truth - estimate; for an angle the shorter way round, in [-wrap/2, wrap/2].
double wrapped_difference(double truth, double estimate, double wrap);

/// Returns true if all states have the same unit (or none). Only then |x - x_hat| has a meaning without scaling.
bool share_a_unit(const std::vector<Channel>& states);

/// Returns the standard deviation of each state over the samples whose truth counts, n_x; for an angle about its mean
/// direction. 1 for a state that never moves. Norms over states with different units use it as a scale.
Eigen::VectorXd state_deviation(const Dataset& dataset);

/// Sums of squared errors over trajectories. Adding in the same order gives the same bits. merge() joins sums of
/// separate parts; its result depends on the order of the merges, not on the number of threads.
class ErrorAccumulator {
 public:
  ErrorAccumulator(std::vector<Channel> states, double sample_period_s, const MetricsConfig& config = {});

  /// Adds one run and returns the norm of its error over all of its samples;
  /// NaN if no sample counts.
  ///   truth     samples with weight 0 are left out
  ///   estimate  n_x x N, one column per sample of truth; a non-finite entry throws codegen::Error
  double add(const Trajectory& truth, const Eigen::MatrixXd& estimate);

  void merge(const ErrorAccumulator& other);

  ErrorMetrics metrics() const;

 private:
  struct Instant {  ///< all samples of the set that fall on the same tick of the sample period
    double squared_error = 0.0;
    double weight = 0.0;
  };

  double norm_of(const Eigen::VectorXd& squared_error, double weight) const;

  std::vector<Channel> states_;
  double sample_period_s_;
  MetricsConfig config_;
  Eigen::VectorXd inverse_square_scale_;  ///< n_x
  Eigen::MatrixXd squared_error_;         ///< n_x x windows, weighted sums
  Eigen::VectorXd weight_;                ///< per window
  double squared_truth_ = 0.0;
  std::int64_t samples_ = 0;
  std::vector<Instant> instants_;
};

/// Returns windows and settling of the experiment, or values derived from its observer and this horizon.
MetricsConfig metrics_config(const Experiment& experiment, double horizon_s);

/// Returns the configuration with the longest of these logs as the horizon.
MetricsConfig metrics_config(const Experiment& experiment, const Dataset& logs);

}  // namespace nlo::trainer
