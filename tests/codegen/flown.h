// SPDX-License-Identifier: MIT
// Flights for the example models, as training would record them, but without a plant.
#pragma once

#include "codegen/model/model.h"

namespace nlo::codegen {

/// `model` with `runs` flights of `samples` each: outputs and inputs wander over `share` of the inner half of their
/// ranges, fast against the tones of a replay; times are irregular.
Model flown(Model model, int runs, int samples, double share = 1.0);

}  // namespace nlo::codegen
