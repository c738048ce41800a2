// SPDX-License-Identifier: MIT
// Exceptions of code generation and training. The message names the place (file, line or field) and the fix. main()
// catches and prints them.
#pragma once

#include <stdexcept>

namespace nlo::codegen {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The input is wrong, even if this is detected late. main() treats it like a wrong option.
struct InputError : Error {
  using Error::Error;
};

}  // namespace nlo::codegen
