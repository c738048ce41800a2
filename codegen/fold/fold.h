// SPDX-License-Identifier: MIT
// From a model to the numbers that fly.
#pragma once

#include "codegen/model/folded.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

FoldedModel fold(const Model& model);

/// Measurements held in a row until the status says stale: one time constant of the fastest mode that reads an output,
/// 5 at least; 10 where no mode is known.
int stale_after(const Model& model);

}  // namespace nlo::codegen
