// SPDX-License-Identifier: MIT
// Short trainings that choose between a few observers, judged on data that they have not been trained on.
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

class Pilots {
 public:
  /// If there are logs and no validation_files, one of four sets of deal_groups() is held out, or one log if there are
  /// fewer than four, or the last quarter of a single log (log_blocks.h). `training` and `validation` must outlive this
  /// object.
  ///   settled_from_s  end of the transient [s], see SplitError
  Pilots(const Experiment& experiment, const Dataset& training, const Dataset& validation, double settled_from_s);

  /// Returns SplitError::both() of a training of at most `steps`; infinite if it diverges. If a part of a single log is
  /// held out, returns the error there of the better one of T* and the linear rows. Throws codegen::Error if the
  /// experiment cannot be trained.
  double error(const Experiment& experiment, int steps) const;

  /// Returns training.steps, a quarter or a sixteenth of them: the number with the smallest error().
  int best_steps(const Experiment& experiment) const;

  /// Returns true if the held-out data is a part of a single log.
  bool holds_out_a_part() const { return holds_out_a_part_; }

 private:
  void hold_out_last_quarter();

  const Dataset& training_;
  const Dataset& validation_;
  Dataset kept_, held_out_;  ///< empty if no log is held out
  bool holds_out_a_part_ = false;
  double settled_from_s_;
};

}  // namespace nlo::trainer
