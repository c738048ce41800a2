// SPDX-License-Identifier: MIT
// Training and validation data of an experiment with a [plant].
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

struct TrainingSets {
  Dataset training, validation;
  std::vector<std::string> warnings = {};  ///< result of range_warnings() for the training runs
};

/// The round of [feedback] that is simulated. Round 0 closes the loop with the true state plus a drawn error, each
/// further round with the observer of the round before.
struct LoopRound {
  int round = 0;
  const codegen::Model* observer = nullptr;
};

/// Simulates both sets from the experiment's seed. The validation set has a quarter as many trajectories (8 to 50),
/// with other initial states. Throws codegen::Error if a trajectory overflows.
TrainingSets simulate_training_sets(const Experiment& experiment, const LoopRound& round = {});

/// Simulates a further round. Its training runs are added to `before`, so that an observer does not forget the states
/// of other loops (data set aggregation, Ross et al. 2011). The validation runs are those of the loop of this round.
TrainingSets next_round(const Experiment& experiment, const LoopRound& round, TrainingSets before);

}  // namespace nlo::trainer
