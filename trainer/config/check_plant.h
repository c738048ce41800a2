// SPDX-License-Identifier: MIT
// The checks of an experiment that are about a plant's angles and initial states, and about angles that the observer
// must turn with, wherever they come from.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct ConfigFault {
  std::string path;  ///< of the key that is wrong: "simulation.initial_low"
  std::string what;  ///< and what to do
};

/// Of the keys initial_... of [simulation], for a plant of `nx` states.
std::optional<ConfigFault> initial_state_fault(const SimulationConfig& simulation, std::size_t nx);

/// Of angles among the outputs and of what a plant's states are estimated as. The plant and the columns are valid.
std::optional<ConfigFault> angle_fault(const Experiment& experiment);

}  // namespace nlo::trainer
