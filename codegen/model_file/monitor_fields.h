// SPDX-License-Identifier: MIT
// Writes, reads and checks the monitor of a model file.
#pragma once

#include <string>

#include "codegen/base/json_field.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

std::string monitor_json(const Monitor& monitor, const std::string& indent);

/// Reads the monitor of a model with `states` states. Files of nlo 0.2.0 may have limits that their statistics cannot
/// reach. They are lowered to limits that can be reached, and Monitor::lowered names them.
Monitor monitor(const Field& field, Eigen::Index states);

/// Throws Error unless the monitor fits the model and each of its alarms can be raised.
void check_monitor(const Model& model);

}  // namespace nlo::codegen
