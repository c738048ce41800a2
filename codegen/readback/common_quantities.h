// SPDX-License-Identifier: MIT
// What an export of any structure must say beside what is the structure's own.
#pragma once

#include <cstdint>

#include "codegen/export/prepared_export.h"
#include "codegen/text/quantity.h"

namespace nlo::codegen {

/// Texts that say the same in names of their own.
enum class TextForm : std::uint8_t {
  kCpp,     ///< the C++ header over the runtime
  kC99,     ///< the pair
  kSingle,  ///< the same in one C++ header
};

void add_common_quantities(Quantities& to, const PreparedExport& prepared, TextForm form);

}  // namespace nlo::codegen
