// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace nlo::trainer {

/// `text` as one word of a POSIX shell, quoted where it must be.
std::string shell_word(const std::string& text);

}  // namespace nlo::trainer
