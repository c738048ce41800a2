// SPDX-License-Identifier: MIT
// Returns plants as expressions, also the built-in ones, for code that differentiates, extends, counts or exports f.
#pragma once

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Returns the plant by expressions, with all of its parameters.
PlantConfig equations_of(const PlantConfig& plant);

}  // namespace nlo::trainer
