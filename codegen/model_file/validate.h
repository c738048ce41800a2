// SPDX-License-Identifier: MIT
// Conditions that every model must satisfy before it is written, read or exported: shapes that agree, finite numbers, a
// latent system that forgets its start, names that are safe in code.
#pragma once

#include "codegen/model/model.h"

namespace nlo::codegen {

/// Throws Error with the field (`inverse_map.layers[2].weights[4][7]`), the reason and the remedy.
void validate(const Model& model);

}  // namespace nlo::codegen
