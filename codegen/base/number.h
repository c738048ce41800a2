// SPDX-License-Identifier: MIT
// Numbers as C++ literals: the shortest that read back to the same bits, in any locale.
#pragma once

#include <string>

namespace nlo::codegen {

/// `1.5f`, `-0.0f`, `1e-07f`. Throws Error when `value` is not finite: no literal says NaN.
std::string literal(float value);

/// `1.5`, `-0.0`, `1e-07`.
std::string literal(double value);

}  // namespace nlo::codegen
