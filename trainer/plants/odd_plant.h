// SPDX-License-Identifier: MIT
// Whether a plant is odd: f(-x, -u) = -f(x, u) and h(-x) = -h(x), except for channels that keep their sign. Then the
// mirror image of a run is a run, which [training] mirror relies on.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// The names of all states, outputs and inputs except those in `even`.
std::vector<std::string> odd_channels(const Plant& plant, const std::vector<std::string>& even);

/// Describes, with numbers, a state near the initial ones at which an equation does not hold if the channels `odd`
/// change their sign. Empty if the equations agree to rounding at 64 random states.
///   driven  inputs act, and f(x, u) is asked; else f(x)
std::optional<std::string> mirror_counterexample(const Plant& plant, const std::vector<std::string>& odd,
                                                 const SimulationConfig& simulation, bool driven = false);

}  // namespace nlo::trainer
