// SPDX-License-Identifier: MIT
#include "trainer/base/shell_word.h"

#include <algorithm>
#include <string_view>

namespace nlo::trainer {

std::string shell_word(const std::string& text) {
  const auto needs_none = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           std::string_view("_./-=:,+%@").find(c) != std::string_view::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), needs_none)) return text;
  std::string word = "'";
  for (const char c : text) {
    if (c == '\'') word += "'\\'";
    word += c;
  }
  return word + "'";
}

}  // namespace nlo::trainer
