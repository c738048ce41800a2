// SPDX-License-Identifier: MIT
// A number of generated text as a compiler reads it.
#pragma once

#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>

namespace nlo::codegen {

/// A literal, or a product of some, where a Scalar is asked for; nothing where it is none.
template <class Scalar>
std::optional<Scalar> read_number(std::string_view text) {
  std::optional<Scalar> product;
  while (true) {
    const std::size_t times = text.find('*');
    const std::string factor(text.substr(0, times));
    char* end = nullptr;
    const bool single = factor.ends_with('f') && !factor.starts_with("0x");
    const auto value = single ? static_cast<Scalar>(std::strtof(factor.c_str(), &end))
                              : static_cast<Scalar>(std::strtod(factor.c_str(), &end));
    if (factor.empty() || std::string_view(end) != (single ? "f" : "")) return std::nullopt;
    product = product ? *product * value : value;
    if (times == std::string_view::npos) return product;
    text.remove_prefix(times + 1);
  }
}

}  // namespace nlo::codegen
