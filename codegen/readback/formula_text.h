// SPDX-License-Identifier: MIT
// A function of generated text that computes: `const float t0 = ...; dx[0] = x[1] + rounded<float>(...);`.
#pragma once

#include "codegen/readback/read_text.h"
#include "codegen/text/quantity.h"

namespace nlo::codegen {

/// Runs `function` over `arrays`, its numbers rounded to the scalar, its operations in double. Throws Error, naming the
/// line, for what is no such function, and for what it reads that is not there.
void run_formula(const ReadFunction& function, bool single, Quantity::Arrays& arrays);

}  // namespace nlo::codegen
