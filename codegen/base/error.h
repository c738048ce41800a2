// SPDX-License-Identifier: MIT
// What code generation and training throw. The message names the place (file, line or field) and the mend; main()
// catches it once and prints it.
#pragma once

#include <stdexcept>

namespace nlo::codegen {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace nlo::codegen
