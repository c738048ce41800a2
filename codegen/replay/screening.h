// SPDX-License-Identifier: MIT
// What an observer makes of a measurement, as nlo/measurement.h does, with dynamic sizes: the reference of its rules.
#pragma once

#include <nlo/vector.h>
#include <Eigen/Core>
#include <vector>

#include "codegen/model/computed_outputs.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

class Screening {
 public:
  /// `model` must outlive it.
  explicit Screening(const Model& model);

  void reset();

  /// Takes a sample of outputs (n_y; those that are computed are computed here) and inputs (n_u), `dt_s` after the last
  /// one. An output that may be missing fades.
  /// An entry that is not finite, or an angle out of its range,
  /// keeps its last good value; others are clamped to their range. With `wrapped`, angles are continued from the last
  /// sample. False before the first sample that is good in all entries: y() and u() are not to be used.
  bool take(const Eigen::VectorXd& outputs, const Eigen::VectorXd& inputs, bool wrapped, double dt_s);

  /// What the next sample meets: y(), u(), and for how many samples each channel has been held (counters() of them).
  Eigen::VectorXd held_values() const;
  Eigen::Index counters() const { return static_cast<Eigen::Index>(held_.size()); }
  /// Goes on from there; `started`: a good sample has been.
  void hold(const Eigen::VectorXd& values, bool started);

  const Eigen::VectorXd& y() const { return y_; }  ///< readings, n_r, as taken: held, clamped, angles unwrapped
  const Eigen::VectorXd& u() const { return u_; }  ///< inputs that are no readings
  StepStatus status() const { return status_; }    ///< kOk, kClamped, kHeld or kStale

  /// Returns kHeld or kStale for an output that the last sample did not have, else kOk.
  StepStatus status(Eigen::Index output) const;

 private:
  const Model& model_;
  ComputedOutputs computed_;
  int stale_after_;
  Eigen::VectorXd low_, high_;  ///< of the readings
  std::vector<double> wrap_;
  bool fill_missing(Eigen::VectorXd& readings, double dt_s) const;

  Eigen::VectorXd y_, u_;
  StepStatus status_ = StepStatus::kOk;
  Eigen::Array<bool, Eigen::Dynamic, 1> missing_;  ///< of the outputs, in the last sample
  std::vector<int> held_;  ///< of each reading, then of each input that is none: samples in a row
  bool started_ = false;
};

}  // namespace nlo::codegen
