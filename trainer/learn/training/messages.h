// SPDX-License-Identifier: MIT
// Messages of a training for people: its progress, and why it stopped.
#pragma once

#include <string>

#include "trainer/config/experiment.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// After a step of that loss.
///   first_step  the steps done before this session
///   session_s   how long this session has taken
TrainProgress progress_of(const Experiment& experiment, const ObserverStructure& structure, const TrainingState& state,
                          double loss, long first_step, double session_s);

/// Says that a training diverged at a step, and what to try. `what`: the observation, "the loss is inf".
std::string divergence_message(const Experiment& experiment, const ObserverStructure& structure, long step,
                               const std::string& what);

}  // namespace nlo::trainer
