// SPDX-License-Identifier: MIT
// The main export: one readable C++20 header that defines nlo::NAME::kModel and its Observer type over the runtime.
#pragma once

#include <string>

#include "codegen/targets/registry.h"

namespace nlo::codegen {

/// The header's text: the same bytes for the same model. Throws Error when the model is not valid, or a number does not
/// fit the scalar.
std::string cpp_header(const Model& model, const ExportOptions& options);

}  // namespace nlo::codegen
