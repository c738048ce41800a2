// SPDX-License-Identifier: MIT
// Names come from models, logs and paths that others made, and a terminal obeys the control characters in them.
#pragma once

#include <string>
#include <string_view>

namespace nlo::trainer {

/// `text` with its control characters as \x1b: those of ASCII but line feed and tab, those of Unicode (U+0080 to
/// U+009F), and bytes that are no UTF-8, which other encodings take for control characters.
std::string printable(std::string_view text);

/// `text` with a ? for each byte that is not printable ASCII.
std::string ascii(std::string_view text);

/// `text` as one word of a POSIX shell, quoted where it must be.
std::string shell_word(const std::string& text);

}  // namespace nlo::trainer
