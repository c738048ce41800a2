// SPDX-License-Identifier: MIT
// What goes into the world: an export that has been read back.
#pragma once

#include <vector>

#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"
#include "codegen/targets/registry.h"

namespace nlo::codegen {

/// The files of `target`, once each observer among them says what the model says (codegen/readback). Throws Error where
/// one does not, and where the model cannot be exported so.
std::vector<NamedText> generated(const ExportTarget& target, const PreparedExport& prepared);

}  // namespace nlo::codegen
