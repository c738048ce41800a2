// SPDX-License-Identifier: MIT
// Returns the error message of an action that must throw.
#pragma once

#include <string>

#include "codegen/base/error.h"

namespace nlo {

/// Returns the message of the codegen::Error that `action` throws, or "no error" if it throws none.
template <class Action>
std::string thrown_message(const Action& action) {
  try {
    (void)action();
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace nlo
