// SPDX-License-Identifier: MIT
// How good an estimate is: the error metrics of the strict protocol, gathered trajectory by trajectory so that a large
// test never has to be held in memory.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// How the time axis is read. Errors at t >= settled_from_s are "settled".
///
/// Settling time: the first t from which the error averaged over the trajectories and over the window [t, t + window)
/// (root mean square) stays within `settling_ratio` times its settled value for the rest of the run.
struct MetricsConfig {
  double settled_from_s = 10.0;
  double settling_ratio = 1.5;
  double settling_window_s = 1.0;
};

/// Every number here is finite; what a run is too short or too quiet to define is empty.
struct ErrorMetrics {
  double norm = 0.0;              ///< sqrt(mean of |x - x_hat|^2) over trajectories and samples, transient included
  std::optional<double> nrmse;    ///< norm / RMS|x|; empty when the truth is zero
  std::optional<double> settled;  ///< norm over t >= 10 s; empty when no run is that long
  Eigen::VectorXd per_component;  ///< n_x, RMSE of each state in its unit
  Eigen::VectorXd settled_per_component;  ///< n_x, the same over t >= 10 s; size 0 when no run is that long
  std::optional<double> settling_time_s;  ///< see MetricsConfig; empty when the error never settles
  Eigen::VectorXd curve_time_s;           ///< error versus time, one entry per sample instant
  Eigen::VectorXd curve;                  ///< sqrt(mean over trajectories of |x - x_hat|^2) at that instant
  std::int64_t samples = 0;               ///< how many samples counted (weight > 0)
};

/// truth - estimate; of an angle the short way round, in [-wrap/2, wrap/2].
double wrapped_difference(double truth, double estimate, double wrap);

/// Sums of squared errors over trajectories. Adding in the same order gives the same bits; merge() joins parts that
/// were gathered apart (the order of the merges counts, not the number of threads behind them).
class ErrorAccumulator {
 public:
  ErrorAccumulator(std::vector<Channel> states, double sample_period_s, const MetricsConfig& config = {});

  /// Adds one run.
  ///   truth     samples with weight 0 are left out
  ///   estimate  n_x x N, one column per sample of truth; a non-finite entry throws codegen::Error
  void add(const Trajectory& truth, const Eigen::MatrixXd& estimate);

  void merge(const ErrorAccumulator& other);

  ErrorMetrics metrics() const;

 private:
  struct Instant {  ///< all samples of the set that fall on the same tick of the sample period
    double squared_error = 0.0;
    double weight = 0.0;
  };

  std::vector<Channel> states_;
  double sample_period_s_;
  MetricsConfig config_;
  Eigen::VectorXd squared_error_, settled_squared_error_;  ///< n_x, weighted sums
  double squared_truth_ = 0.0, weight_ = 0.0, settled_weight_ = 0.0;
  std::int64_t samples_ = 0;
  std::vector<Instant> instants_;
};

}  // namespace nlo::trainer
