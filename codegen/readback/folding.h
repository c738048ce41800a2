// SPDX-License-Identifier: MIT
// The numbers that an export is compared with are the model's: normalisation, features and steps are folded again, in
// long double and by other formulas than codegen/fold has.
#pragma once

#include "codegen/model/folded.h"
#include "codegen/model/model.h"
#include "codegen/text/export_options.h"

namespace nlo::codegen {

/// Throws Error, naming the field, both values, unless `folded` is `model` in weights of this type: each number within
/// some roundings of what it is a sum of, 16-bit weights within half a unit more. Steps of a linear latent system: by
/// the exponential series, or one step of Runge-Kutta.
void check_folding(const Model& model, const FoldedModel& folded, WeightType weights);

}  // namespace nlo::codegen
