// SPDX-License-Identifier: MIT
// Folders with the C99 pair and what another framework puts around it: each file comes from a template
// (templates/simulink, templates/px4).
#pragma once

#include <vector>

#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"

namespace nlo::codegen {

/// A level-2 S-function for Simulink. Throws Error when c99() does.
std::vector<NamedText> simulink(const PreparedExport& prepared);

/// A module for PX4. Throws Error when c99() does.
std::vector<NamedText> px4_module(const PreparedExport& prepared);

}  // namespace nlo::codegen
