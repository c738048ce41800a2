// SPDX-License-Identifier: MIT
// Where a training run writes: checked before anything is computed, created only when there is something to write.
#pragma once

#include <string>

namespace nlo::trainer {

struct OutputDirectory {
  std::string path;
  bool resume = false;
  bool force = false;  ///< replace what another experiment left there
};

/// Throws codegen::Error when the directory cannot be made or written to, when it holds another experiment's model (and
/// not `force`), or when there is no checkpoint to resume from.
void check_output_directory(const OutputDirectory& directory, const std::string& experiment_name);

/// Makes it, with what is above it. Throws codegen::Error.
void make_output_directory(const std::string& path);

/// Throws codegen::Error when `file` cannot be made: no such directory, or itself a directory.
void check_output_file(const std::string& file);

}  // namespace nlo::trainer
