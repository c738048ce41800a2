// SPDX-License-Identifier: MIT
// A plant is odd when f(-x) = -f(x) and h(-x) = -h(x): then the mirror image (-x, -y) of a run is a run of it, which is
// what [training] mirror takes for granted.
#pragma once

#include <optional>
#include <string>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// A state about the initial ones at which f or h is not odd, in words; empty when 64 random ones agree to rounding.
std::optional<std::string> odd_counterexample(const Plant& plant, const SimulationConfig& simulation);

}  // namespace nlo::trainer
