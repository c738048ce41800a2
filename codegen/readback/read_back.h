// SPDX-License-Identifier: MIT
// An export is what its model says: its text is read back, and each constant compared with the model's, to the bit.
#pragma once

#include <vector>

#include "codegen/base/file.h"
#include "codegen/readback/common_quantities.h"

namespace nlo::codegen {

/// Throws Error unless `files` together say each constant of `prepared` and no other: the constant, its file and line,
/// both values.
void check_text(const PreparedExport& prepared, TextForm form, const std::vector<NamedText>& files);

}  // namespace nlo::codegen
