// SPDX-License-Identifier: MIT
// Messages of a training for users: its progress, and the reason why it stopped.
#pragma once

#include <string>

#include "trainer/config/experiment.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Returns the progress after a step with this loss.
///   first_step  number of steps before this session
///   session_s   duration of this session so far
TrainProgress progress_of(const Experiment& experiment, const ObserverStructure& structure, const TrainingState& state,
                          double loss, long first_step, double session_s);

/// Returns a text which says that a training diverged at a step, and what to try. `what`: the observation, such as "the
/// loss is inf".
std::string divergence_message(const Experiment& experiment, const ObserverStructure& structure, long step,
                               const std::string& what);

}  // namespace nlo::trainer
