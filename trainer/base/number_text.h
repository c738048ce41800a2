// SPDX-License-Identifier: MIT
// Converts numbers from and to text, the same in every locale.
#pragma once

#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace nlo::trainer {

/// Returns the text as a finite number; nothing unless the whole text is one.
inline std::optional<double> finite_number(std::string_view text) {
  double value = 0.0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc{} || stop != end || !std::isfinite(value)) return std::nullopt;
  return value;
}

/// Returns the fewest digits that read back to the same double: "0.5", "1e-06".
inline std::string shortest_text(double value) {
  char buffer[32];  // the longest such text of a double has 24 characters
  return std::string(buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr);
}

}  // namespace nlo::trainer
