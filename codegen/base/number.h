// SPDX-License-Identifier: MIT
// Numbers as C++ literals: the shortest literals that read back to the same bits, in any locale.
#pragma once

#include <string>

namespace nlo::codegen {

/// Returns `1.5f`, `-0.0f`, `1e-07f`. Throws Error if `value` is not finite, because there is no literal of NaN.
std::string literal(float value);

/// Returns `1.5`, `-0.0`, `1e-07`.
std::string literal(double value);

}  // namespace nlo::codegen
