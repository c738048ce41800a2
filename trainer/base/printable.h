// SPDX-License-Identifier: MIT
// Makes names safe to print. They come from models, logs and paths of others, and a terminal obeys control characters.
#pragma once

#include <string>
#include <string_view>

namespace nlo::trainer {

/// Returns `text` with its control characters as \x1b: those of ASCII except line feed and tab, those of Unicode
/// (U+0080 to U+009F), and bytes that are not UTF-8, which other encodings take for control characters.
std::string printable(std::string_view text);

/// Returns `text` with a ? for each byte that is not printable ASCII.
std::string ascii(std::string_view text);

/// Returns `text` as one word of a POSIX shell, quoted if necessary.
std::string shell_word(const std::string& text);

}  // namespace nlo::trainer
