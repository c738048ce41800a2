// SPDX-License-Identifier: MIT
// The monitor of a model file: written, read, checked.
#pragma once

#include <string>

#include "codegen/base/json_field.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

std::string monitor_json(const Monitor& monitor, const std::string& indent);
Monitor monitor(const Field& field);

/// Throws Error unless it is one for this model.
void check_monitor(const Model& model);

}  // namespace nlo::codegen
