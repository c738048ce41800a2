// SPDX-License-Identifier: MIT
// Tests whether a plant is odd: f(-x, -u) = -f(x, u) and h(-x) = -h(x), except for channels that keep their sign. The
// mirror image of a run of an odd plant is also a run, which [training] mirror uses.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Returns the names of all states, outputs and inputs except those in `even`.
std::vector<std::string> odd_channels(const Plant& plant, const std::vector<std::string>& even);

/// Describes, with numbers, a state near the initial ones at which an equation does not hold if the channels `odd`
/// change their sign. Empty if the equations agree to rounding at 64 random states.
///   driven  inputs act: f(x, u) is tested, otherwise f(x)
std::optional<std::string> mirror_counterexample(const Plant& plant, const std::vector<std::string>& odd,
                                                 const SimulationConfig& simulation, bool driven = false);

}  // namespace nlo::trainer
