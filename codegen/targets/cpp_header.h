// SPDX-License-Identifier: MIT
// Writes the main export: one readable C++20 header that defines nlo::NAME::kModel and its Observer type with the
// runtime.
#pragma once

#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Returns the header's text, with the same bytes for the same model. Throws Error if the scalar cannot represent a
/// number.
std::string cpp_header(const PreparedExport& prepared);

}  // namespace nlo::codegen
