// SPDX-License-Identifier: MIT
// The equations of nlo/monitor.h with dynamic sizes, in double: the reference of its rules. Limits are found and
// tested with it.
#pragma once

#include <nlo/monitor.h>
#include <Eigen/Core>
#include <vector>

#include "codegen/model/domain.h"
#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"

namespace nlo::codegen {

/// [z - S y; y; x_hat] of each sample of a run, (n_z + n_r + n_x) x N, for predictions. Entries that must
/// not affect a prediction are zero: readings that T* uses only as z - S y, and estimates of angles that turn.
Eigen::MatrixXd monitor_features(const Model& model, const Run& run);

class ReferenceMonitor {
 public:
  /// Copies the monitor; `model` must outlive it.
  ReferenceMonitor(const Model& model, Monitor monitor);

  void reset();

  /// Returns the outputs (n_y) as the observer should be given them: NaN beyond the gate or of a frozen sensor.
  /// `dt_s`: since the last sample; 0: one sample period.
  Eigen::VectorXd usable_outputs(const Eigen::VectorXd& y, double dt_s = 0.0);

  /// Judges a sample after the observer's step: z, readings as it took them (n_r, angles unwrapped), x_hat, and the
  /// status of each output. `arrived`: whether each output arrived; empty: all did.
  void watch(const Eigen::VectorXd& z, const Eigen::VectorXd& readings, const Eigen::VectorXd& x_hat,
             const std::vector<StepStatus>& status, const std::vector<bool>& arrived = {});

  /// Each statistic over its limit: of each output and window p / max(v, least), v, |r|; then d of each window; then
  /// the share of missing measurements of each output; then b of each state.
  const Eigen::VectorXd& levels() const { return levels_; }

  /// As Monitor::widened(): sigma, n_x, times max(1, b / kOrdinaryDisagreement), or kUnknownSigma while there is an
  /// alarm.
  Eigen::VectorXd widened(const Eigen::VectorXd& sigma) const;
  bool armed() const { return samples_ > armed_after_; }
  Alarm alarm() const;
  /// Measurements that usable_outputs() kept away since reset().
  Eigen::Index rejected() const { return all_rejected_; }

  /// The alarm that each entry of levels() stands for, for a model with these limits.
  static std::vector<Alarm> meanings(const Model& model, const Monitor& monitor);

 private:
  double innovation(Eigen::Index j, double y) const;

  const Model& model_;
  Monitor monitor_;
  std::vector<Alarm> meanings_;
  Eigen::MatrixXd steady_;  // S of relative readings
  FlownRanges ranges_;
  Eigen::VectorXd gain_;      // one smoothing factor per window
  std::vector<int> not_due_;  // n_r, samples for which a reading is not due (fold.h)
  int armed_after_;

  Eigen::MatrixXd mean_, power_, variance_, correlation_;  // n_y x windows
  Eigen::VectorXd distance_, missing_share_, disagreement_, levels_;
  Eigen::VectorXd y_, predicted_, last_;
  Eigen::Array<bool, Eigen::Dynamic, 1> missing_;
  std::vector<Repeats> repeats_;
  Eigen::VectorXi rejected_;
  double place_ = 0.0;                    // mean |off| of the last sample
  bool gated_ = false, started_ = false;  // usable_outputs() has seen the next sample; watch() has seen one
  int samples_ = 0;
  Eigen::Index all_rejected_ = 0;
};

/// A whole trajectory from reset, as ReferenceObserver::run() computes it, with the monitor beside it.
struct WatchedRun {
  Run run;
  Eigen::MatrixXd levels;     ///< levels() x N
  std::vector<Alarm> alarms;  ///< N
  int armed_after = 0;        ///< samples before levels above 1 are alarms
  Eigen::Index rejected = 0;
};

/// Whether outputs pass usable_outputs() before the step.
enum class Gate { kUsed, kNotUsed };

/// `time_s`: N time stamps whose differences are the steps; empty: each is one sample period.
WatchedRun watched_run(const Model& model, const Monitor& monitor, const Eigen::MatrixXd& outputs,
                       const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s = {}, Gate gate = Gate::kUsed);

}  // namespace nlo::codegen
