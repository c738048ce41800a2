// SPDX-License-Identifier: MIT
// Validates measurements as nlo/measurement.h does, with dynamic sizes. It is the reference for its rules.
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
  /// `model` must outlive this object.
  SampleValidation(const Model& model, FlownRanges ranges);

  void reset();

  /// Validates a sample of outputs (n_y; computed outputs are computed here) and inputs (n_u), `dt_s` after the last
  /// one. A missing output with may_fail decays to its mean. An entry that is not finite keeps its last good value, and
  /// so does an angle out of its range; others are clamped. With `wrapped`, angles are continued from the last sample.
  /// An output that T* reads only relatively always is (flown_ranges.h). After a step beyond 1.5 sample periods,
  /// samples count as missing. Returns false before the first sample whose entries are all good; then y() and u() are
  /// not valid.
  bool validate(const Eigen::VectorXd& outputs, const Eigen::VectorXd& inputs, bool wrapped, double dt_s);

  /// Subtracts whole turns from the outputs that T* reads only relatively, if they have left the first turn. Returns
  /// these turns times W, n_r.
  Eigen::VectorXd turn_back();

  /// Returns the state of the validation: y(), u(), and the health of each of channels() channels.
  Eigen::VectorXd held_values() const;
  Eigen::Index channels() const { return static_cast<Eigen::Index>(health_.size()); }
  /// Continues from a saved state. `started`: true if there has been a good sample.
  void hold(const Eigen::VectorXd& values, bool started);

  const Eigen::VectorXd& y() const { return y_; }  ///< readings after validation, n_r: held, clamped, angles unwrapped
  const Eigen::VectorXd& u() const { return u_; }  ///< inputs that are not readings
  StepStatus status() const { return status_; }    ///< kOk, kClamped, kHeld, kStale or kOutOfRange
  bool clamped() const;                            ///< true if a reading of the last sample was clamped
  /// Returns, for each output, true if it was measured in the last sample, neither held nor missing.
  const std::vector<bool>& arrived() const { return arrived_; }

  /// Returns the status of one output in the last sample.
  StepStatus status(Eigen::Index output) const { return status_of(static_cast<std::size_t>(output)); }

  /// Returns true if an output arrived in the last sample, or if it has no period of its own.
  bool has_arrived(Eigen::Index output) const {
    const auto channel = static_cast<std::size_t>(output);
    const Health& h = health_[channel];
    return not_due_[channel] == 0 || (!h.held && !(h.clamped && h.late));
  }

 private:
  /// Health of a channel: the number of consecutive samples that were not used unchanged, and what happened to the last
  /// one.
  struct Health {
    int count = 0;
    bool held = false;     ///< its last good value was used
    bool clamped = false;  ///< it was clamped to its range
    bool late = false;     ///< samples before it were missing
  };
  StepStatus status_of(std::size_t channel) const;
  int late(std::size_t channel) const;  ///< samples since it was due; 0: not late

  const Model& model_;
  ComputedOutputs computed_;
  int stale_after_;
  std::vector<int> not_due_;  ///< for each channel (fold.h)
  FlownRanges ranges_;
  /// For each reading: true if an output that may fail is missing, and the number of samples since a slow output
  /// arrived.
  struct Filled {
    std::vector<bool> missing;
    std::vector<int> age;
  };
  /// Replaces missing outputs.
  Filled fill_missing(Eigen::VectorXd& readings, double dt_s) const;
  int missed_samples(double dt_s) const;
  bool may_fail(std::size_t channel) const;

  Eigen::VectorXd y_, u_;
  StepStatus status_ = StepStatus::kOk;
  std::vector<bool> arrived_;
  std::vector<Health> health_;  ///< one for each reading, then one for each input that is not a reading
  bool started_ = false;
};

}  // namespace nlo::codegen
