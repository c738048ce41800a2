// SPDX-License-Identifier: MIT
// A folder for Simulink: the C99 pair and a level-2 S-function around it, from templates/simulink.
#pragma once

#include <vector>

#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"

namespace nlo::codegen {

/// Throws Error when c99() does.
std::vector<NamedText> simulink(const PreparedExport& prepared);

}  // namespace nlo::codegen
