// SPDX-License-Identifier: MIT
// Integers as text: the differences of neighbours in Base64 VLQ, as in the source maps of browsers. A character has 5
// bits of a difference, the lowest first, and one that says whether more follow; the lowest bit of all is the sign.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

namespace nlo::codegen {

std::string to_vlq(const Eigen::VectorXi& values);

/// Nothing when the text has another character, ends within a number, or has a number beyond `most` in size.
std::optional<Eigen::VectorXi> from_vlq(std::string_view text, int most);

}  // namespace nlo::codegen
