// SPDX-License-Identifier: MIT
// Validation of measurements as in nlo/measurement.h, with dynamic sizes: the reference of its rules.
#pragma once

#include <nlo/vector.h>
#include <Eigen/Core>
#include <vector>

#include "codegen/model/computed_outputs.h"
#include "codegen/model/flown_ranges.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

class SampleValidation {
 public:
  /// `model` must outlive it.
  SampleValidation(const Model& model, FlownRanges ranges);

  void reset();

  /// Validates a sample of outputs (n_y; those that are computed are computed here) and inputs (n_u), `dt_s` after the
  /// last one. An output that may be missing fades. An entry that is not finite keeps its last good value, and so does
  /// an angle out of its range; others are clamped. With `wrapped`, angles are continued from the last sample. An
  /// output that T* knows only relatively always is (flown_ranges.h). A step beyond 1.5 sample periods has missed
  /// samples. False before the first sample that is good in all entries: y() and u() are not to be used.
  bool validate(const Eigen::VectorXd& outputs, const Eigen::VectorXd& inputs, bool wrapped, double dt_s);

  /// Takes whole turns away from the outputs that T* knows only relatively, where they have left the first: those turns
  /// times W, n_r.
  Eigen::VectorXd turn_back();

  /// All that the next sample depends on: y(), u(), and the health of each channel (channels() of them).
  Eigen::VectorXd held_values() const;
  Eigen::Index channels() const { return static_cast<Eigen::Index>(health_.size()); }
  /// Continues from there; `started`: there has been a good sample.
  void hold(const Eigen::VectorXd& values, bool started);

  const Eigen::VectorXd& y() const { return y_; }  ///< readings, n_r, as taken: held, clamped, angles unwrapped
  const Eigen::VectorXd& u() const { return u_; }  ///< inputs that are no readings
  StepStatus status() const { return status_; }    ///< kOk, kClamped, kHeld, kStale or kOutOfRange
  bool clamped() const;                            ///< a reading of the last sample
  /// For each output: it was measured in the last sample, neither held nor missing.
  const std::vector<bool>& arrived() const { return arrived_; }

  /// Status of one output in the last sample.
  StepStatus status(Eigen::Index output) const { return status_of(static_cast<std::size_t>(output)); }

  /// Returns true if an output arrived in the last sample, and for one without a period of its own.
  bool has_arrived(Eigen::Index output) const {
    const auto channel = static_cast<std::size_t>(output);
    const Health& h = health_[channel];
    return not_due_[channel] == 0 || (!h.held && !(h.clamped && h.late));
  }

 private:
  /// Health of a channel: the number of samples in a row that were not used unchanged, and the event of the last.
  struct Health {
    int count = 0;
    bool held = false;     ///< its last good value was used
    bool clamped = false;  ///< it was clamped to its range
    bool late = false;     ///< samples were missed before it
  };
  StepStatus status_of(std::size_t channel) const;
  int late(std::size_t channel) const;  ///< samples since it was due; 0: it is not late

  const Model& model_;
  ComputedOutputs computed_;
  int stale_after_;
  std::vector<int> not_due_;  ///< for each channel (fold.h)
  FlownRanges ranges_;
  /// For each reading: whether an output that may fail is missing, and the samples since a slow one arrived.
  struct Filled {
    std::vector<bool> missing;
    std::vector<int> age;
  };
  /// Fills in missing outputs.
  Filled fill_missing(Eigen::VectorXd& readings, double dt_s) const;
  int missed_samples(double dt_s) const;
  bool may_fail(std::size_t channel) const;

  Eigen::VectorXd y_, u_;
  StepStatus status_ = StepStatus::kOk;
  std::vector<bool> arrived_;
  std::vector<Health> health_;  ///< health of each reading, then of each input that is no reading
  bool started_ = false;
};

}  // namespace nlo::codegen
