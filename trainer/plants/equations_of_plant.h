// SPDX-License-Identifier: MIT
// Plants as expressions, the built-in ones too, for code that differentiates, extends, counts or exports f.
#pragma once

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Returns the plant by expressions, with all of its parameters.
PlantConfig equations_of(const PlantConfig& plant);

}  // namespace nlo::trainer
