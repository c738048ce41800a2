// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <string_view>

namespace nlo::trainer {

/// Returns `text` without the characters of `blanks` at its ends. Inline, because logs have millions of cells.
inline std::string_view trimmed(std::string_view text, std::string_view blanks = " \t") {
  const auto is_blank = [&](char c) { return std::ranges::find(blanks, c) != blanks.end(); };
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

}  // namespace nlo::trainer
