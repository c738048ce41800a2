// SPDX-License-Identifier: MIT
// Whether a plant has a symmetry: f(g x, g u) = g f(x, u) and h(g x) = g h(x) for elements g of a declared group. Then
// the image of a run is a run, which training takes for granted.
#pragma once

#include <optional>
#include <string>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Turns the signs of all states, outputs and inputs but of those named in `even`.
SymmetryConfig odd_symmetry(const Plant& plant, const std::vector<std::string>& even);

/// A state about the initial ones at which an equation does not hold, in words with numbers; empty when 64 random ones
/// agree to rounding, each for several elements.
///   symmetry  of names of the plant
///   driven    inputs act, and f(x, u) is asked; else f(x)
std::optional<std::string> symmetry_counterexample(const Plant& plant, const SymmetryConfig& symmetry,
                                                   const SimulationConfig& simulation, bool driven = false);

}  // namespace nlo::trainer
