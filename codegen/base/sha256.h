// SPDX-License-Identifier: MIT
// SHA-256 (FIPS 180-4): tells a person that a file is the one that was looked at, where somebody may want it not to be.
#pragma once

#include <string>
#include <string_view>

namespace nlo::codegen {

/// 64 hex digits, as sha256sum prints them.
std::string sha256(std::string_view bytes);

}  // namespace nlo::codegen
