// SPDX-License-Identifier: MIT
// Why a recording is refused.
#pragma once

#include <string>

#include "codegen/base/error.h"
#include "trainer/recordings/recording.h"

namespace nlo::trainer {

/// The error; empty where it is read.
inline std::string refusal(const std::string& file, const WantedColumns& wanted) {
  try {
    read_recording(file, wanted);
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace nlo::trainer
