// SPDX-License-Identifier: MIT
// The equations of nlo/monitor.h with dynamic sizes, in double. It is the reference for its rules, and limits are found
// and tested with it.
#pragma once

#include <nlo/monitor.h>
#include <Eigen/Core>
#include <vector>

#include "codegen/model/domain.h"
#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"

namespace nlo::codegen {

/// Returns [z - S y; y; x_hat] of each sample of a run, (n_z + n_r + n_x) x N, for predictions. Entries that must not
/// affect a prediction are zero: readings that T* only uses as z - S y, and estimates of angles that turn.
Eigen::MatrixXd monitor_features(const Model& model, const Run& run);

class ReferenceMonitor {
 public:
  /// Copies `monitor`. `model` must outlive this object.
  ReferenceMonitor(const Model& model, Monitor monitor);

  void reset();

  /// Returns the outputs (n_y) for the observer. A rejected or frozen one is NaN, or the predicted output where the
  /// monitor replaces it. `dt_s`: time since the last sample; 0: one sample period.
  Eigen::VectorXd usable_outputs(const Eigen::VectorXd& y, double dt_s = 0.0);

  /// Judges a sample after the step of the observer: z, the readings that it used (n_r, angles unwrapped), x_hat, and
  /// the status of each output. `arrived`: true for each output that arrived; empty: all arrived.
  void watch(const Eigen::VectorXd& z, const Eigen::VectorXd& readings, const Eigen::VectorXd& x_hat,
             const std::vector<StepStatus>& status, const std::vector<bool>& arrived = {});

  /// Each statistic divided by its limit: p / max(v, least), v, |r| of each output and window, then d of each window,
  /// then the share of missing measurements of each output, then b of each state.
  const Eigen::VectorXd& levels() const { return levels_; }

  /// Returns sigma (n_x) as Monitor::widened() does: times max(1, b / kOrdinaryDisagreement), or kUnknownSigma during
  /// an alarm.
  Eigen::VectorXd widened(const Eigen::VectorXd& sigma) const;
  bool armed() const { return samples_ > armed_after_; }
  Alarm alarm() const;
  /// Returns the number of measurements that usable_outputs() rejected since reset().
  Eigen::Index rejected() const { return all_rejected_; }

  /// Returns the alarm that belongs to each entry of levels(), for a model with these limits.
  static std::vector<Alarm> meanings(const Model& model, const Monitor& monitor);

 private:
  double innovation(Eigen::Index j, double y) const;
  double predicted_output(Eigen::Index j) const;

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
  double place_ = 0.0;                    // mean |off| in the last sample
  bool gated_ = false, started_ = false;  // usable_outputs() has seen the next sample; watch() has seen one
  int samples_ = 0;
  Eigen::Index all_rejected_ = 0;
};

/// A whole trajectory from reset, as ReferenceObserver::run() computes it, and its monitor.
struct WatchedRun {
  Run run;
  Eigen::MatrixXd levels;     ///< levels() x N
  std::vector<Alarm> alarms;  ///< N
  int armed_after = 0;        ///< number of samples before levels above 1 are alarms
  Eigen::Index rejected = 0;
};

/// Outputs may pass usable_outputs() before the step, or not.
enum class Gate { kUsed, kNotUsed };

/// `time_s`: N time stamps whose differences are the steps; empty: each is one sample period.
WatchedRun watched_run(const Model& model, const Monitor& monitor, const Eigen::MatrixXd& outputs,
                       const Eigen::MatrixXd& inputs, const Eigen::VectorXd& time_s = {}, Gate gate = Gate::kUsed);

}  // namespace nlo::codegen
