// SPDX-License-Identifier: MIT
// The message of a refusal.
#pragma once

#include <string>

#include "codegen/base/error.h"

namespace nlo {

/// The message of the codegen::Error that `action` throws; "no error" when it throws none.
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
