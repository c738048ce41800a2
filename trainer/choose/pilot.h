// SPDX-License-Identifier: MIT
// Short trainings that choose between a few observers, judged on data that they have not been trained on.
#pragma once

#include <string>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Training and validation data of pilots. Of logs without validation_files every fourth is held out, or one of fewer
/// than four.
class PilotData {
 public:
  /// The sets outlive it.
  PilotData(const Experiment& experiment, const Dataset& training, const Dataset& validation);

  const Dataset& training() const { return kept_.trajectories.empty() ? training_ : kept_; }
  const Dataset& validation() const { return held_out_.trajectories.empty() ? validation_ : held_out_; }

 private:
  const Dataset& training_;
  const Dataset& validation_;
  Dataset kept_, held_out_;  ///< empty where the sets are taken as they are
};

/// The least validation error of a training of `steps`; infinite for one that diverges.
double pilot_error(const Experiment& experiment, int steps, const PilotData& data);

}  // namespace nlo::trainer
