// SPDX-License-Identifier: MIT
// What an experiment with a [plant] trains on and chooses its model by.
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

struct TrainingSets {
  Dataset training, validation;
};

/// Simulates both from the experiment's seed; the validation set has a quarter as many trajectories (8 to 50), from
/// initial states of its own. Throws codegen::Error when a trajectory leaves the numbers.
TrainingSets simulate_training_sets(const Experiment& experiment);

}  // namespace nlo::trainer
