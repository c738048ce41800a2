// SPDX-License-Identifier: MIT
// The monitor of a C++ header: constants and types.
#pragma once

#include <string>

#include "codegen/model/model.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// Of a model that has one.
std::string cpp_monitor(const Model& model, const Initialiser& init);

}  // namespace nlo::codegen
