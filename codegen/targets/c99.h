// SPDX-License-Identifier: MIT
// The observer in C99, for compilers that have no C++20: NAME.h and NAME.c, which need no library at all and give the
// bits of the C++ runtime's deterministic policy. KKL observers (16) and gated ones.
#pragma once

#include <string>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/export/prepared_export.h"

namespace nlo::codegen {

/// Throws Error, naming the mend, unless the model is of a structure that this target writes.
void check_c99(const Model& model);

/// NAME.h and NAME.c: the same bytes for the same model. Throws Error when check_c99() does, or when a
/// number does not fit the scalar.
std::vector<NamedText> c99(const PreparedExport& prepared);

}  // namespace nlo::codegen
