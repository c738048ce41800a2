// SPDX-License-Identifier: MIT
// The monitor of a C99 observer.
#pragma once

#include <map>
#include <string>

#include "codegen/model/model.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// Sets MONITOR and MONITOR_BODY, which name templates (empty if the model has no monitor), and the values of their
/// keys.
void add_c99_monitor(const Model& model, const Initialiser& init, std::map<std::string, std::string>& values);

}  // namespace nlo::codegen
