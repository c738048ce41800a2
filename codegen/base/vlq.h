// SPDX-License-Identifier: MIT
// Integers as text: differences of neighbours in Base64 VLQ, as in source maps of browsers. A character holds 5 bits of
// a difference, the lowest first, and a bit that says whether more characters follow. The lowest bit of a difference is
// its sign.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

namespace nlo::codegen {

std::string to_vlq(const Eigen::VectorXi& values);

/// Returns nothing if the text has another character, ends within a number, or has a number larger than `most` in
/// magnitude.
std::optional<Eigen::VectorXi> from_vlq(std::string_view text, int most);

}  // namespace nlo::codegen
