// SPDX-License-Identifier: MIT
// Writes the C99 export as one C++20 header without headers of nlo, for reviewers who must read all code in flight: the
// templates of c99 in C++, with dense layers as plain loops. The results are those of the deterministic policy.
#pragma once

#include <string>

#include "codegen/targets/prepared_export.h"

namespace nlo::codegen {

/// Returns the header. The same model gives the same bytes. Throws Error when c99() does.
std::string single_header(const PreparedExport& prepared);

}  // namespace nlo::codegen
