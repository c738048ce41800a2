// SPDX-License-Identifier: MIT
// The words, numbers and marks of C and C++ text: without comments and preprocessor lines.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::codegen {

struct Token {
  enum class Kind : std::uint8_t {
    kWord,    ///< with the scopes before it: "weights::kLayer1"
    kNumber,  ///< without its sign
    kMark,    ///< one character
    kText,    ///< in quotation marks
  };
  Kind kind;
  std::string text;
  int line;        ///< from 1
  std::size_t at;  ///< in the text

  bool is(std::string_view mark) const { return kind != Kind::kText && text == mark; }
};

std::vector<Token> tokens_of(std::string_view text);

}  // namespace nlo::codegen
