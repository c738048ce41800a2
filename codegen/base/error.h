// SPDX-License-Identifier: MIT
// What code generation and training throw. The message names the place (file, line or field) and the mend; main()
// catches it once and prints it.
#pragma once

#include <stdexcept>

namespace nlo::codegen {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// What was given is wrong, however late it was seen: main() answers it as it does a wrong option.
struct InputError : Error {
  using Error::Error;
};

}  // namespace nlo::codegen
