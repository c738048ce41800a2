// SPDX-License-Identifier: MIT
// A plant is odd when f(S x) = S f(x) and h(S x) = S_y h(x), where S and S_y turn the signs of all channels but of
// those declared even: then the mirror image (S x, S_y y) of a run is a run of it,
// which [training] mirror takes for granted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// A state about the initial ones at which f or h is not odd, in words; empty when 64 random ones agree to rounding.
///   even    names of states, outputs and inputs whose sign stays
///   driven  inputs act, and f(x, u) is asked; else f(x)
std::optional<std::string> odd_counterexample(const Plant& plant, const std::vector<std::string>& even,
                                              const SimulationConfig& simulation, bool driven = false);

}  // namespace nlo::trainer
