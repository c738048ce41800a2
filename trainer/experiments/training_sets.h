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
  std::vector<std::string> warnings = {};  ///< range_warnings() of the training runs
};

/// Which round of [feedback] is simulated. Round 0 closes the loop by the true state and the drawn error, each further
/// one by the observer of the round before.
struct LoopRound {
  int round = 0;
  const codegen::Model* observer = nullptr;
};

/// Simulates both from the experiment's seed; the validation set has a quarter as many trajectories (8 to 50), from
/// initial states of its own. Throws codegen::Error when a trajectory leaves the numbers.
TrainingSets simulate_training_sets(const Experiment& experiment, const LoopRound& round = {});

/// A further round: its training runs are added to those `before` it, so that an observer does not forget the states of
/// other loops (data set aggregation, Ross et al. 2011);
/// validation is in the loop of the round.
TrainingSets next_round(const Experiment& experiment, const LoopRound& round, TrainingSets before);

}  // namespace nlo::trainer
