// SPDX-License-Identifier: MIT
// Where a command writes: checked before anything is computed, created only when there is something to write.
#pragma once

#include <string>

namespace nlo::trainer {

struct OutputDirectory {
  std::string path;
  bool resume = false;
  bool force = false;  ///< replace what another experiment left there
};

/// Throws codegen::Error when the directory cannot be made or written to, when it holds another experiment's model (and
/// not `force`), when a model is to be resumed that has no checkpoint, or when it is "-": stdout is no folder.
void check_output_directory(const OutputDirectory& directory, const std::string& experiment_name);

/// Makes it, with what is above it. Throws codegen::Error.
void make_output_directory(const std::string& path);

/// "-", which stands for stdout where a command writes one file; nothing else goes there then.
bool is_stdout(const std::string& output);

/// Throws codegen::Error when `file` cannot be made: no such directory (unless `makes_folder`: the command makes it),
/// or itself a directory. Stdout always can.
void check_output_file(const std::string& file, bool makes_folder = false);

/// Makes the folder that `file` lies in. Throws codegen::Error.
void make_folder_of(const std::string& file);

/// Replaces `file`, or writes to stdout.
void write_output_file(const std::string& file, const std::string& text);

}  // namespace nlo::trainer
