// SPDX-License-Identifier: MIT
// Options of the form "key=value,key=value", and decimal numbers in any locale.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace nlo::codegen {

/// Returns the pairs of `text` in their order. Throws Error, naming `option`, for a key without value or given twice.
std::vector<std::pair<std::string, std::string>> key_values(std::string_view text, const std::string& option);

/// Returns `text` as a number; NaN unless the whole text is a number.
double decimal(std::string_view text);

}  // namespace nlo::codegen
