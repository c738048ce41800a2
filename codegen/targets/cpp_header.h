// SPDX-License-Identifier: MIT
// The main export: one readable C++20 header that defines nlo::NAME::kModel and its Observer type over the runtime.
#pragma once

#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// The header's text: the same bytes for the same model. Throws Error when a number does not fit the scalar.
std::string cpp_header(const PreparedExport& prepared);

}  // namespace nlo::codegen
