// SPDX-License-Identifier: MIT
// Flights for the example models, like those that training records, but without a plant.
#pragma once

#include "codegen/model/model.h"

namespace nlo::codegen {

/// Returns `model` with `runs` flights of `samples` samples each: outputs and inputs vary over `share` of the inner
/// half of their ranges, faster than the tones of a replay; times are irregular.
Model flown(Model model, int runs, int samples, double share = 1.0);

}  // namespace nlo::codegen
