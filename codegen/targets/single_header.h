// SPDX-License-Identifier: MIT
// The C99 export as one C++20 header that includes nothing of ours: for those who must read all that flies. The same
// templates in C++, dense layers as plain loops; the bits of the deterministic policy.
#pragma once

#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Writes the header; the same model gives the same bytes. Throws Error when c99() does.
std::string single_header(const PreparedExport& prepared);

}  // namespace nlo::codegen
