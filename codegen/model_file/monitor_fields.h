// SPDX-License-Identifier: MIT
// The monitor of a model file: written, read, checked.
#pragma once

#include <string>

#include "codegen/base/json_field.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

std::string monitor_json(const Monitor& monitor, const std::string& indent);

/// Reads the monitor of a model of so many states. A limit that its statistic cannot reach, as files of nlo 0.2.0 have
/// them, is lowered to one that it can, and named in Monitor::lowered.
Monitor monitor(const Field& field, Eigen::Index states);

/// Throws Error unless the model's monitor fits the model and each of its alarms can fire.
void check_monitor(const Model& model);

}  // namespace nlo::codegen
