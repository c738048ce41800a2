// SPDX-License-Identifier: MIT
// The output directory of a command. It is checked before anything is computed, and made only when there is something
// to write.
#pragma once

#include <string>
#include <vector>

#include "trainer/app/commands/directory_lock.h"

namespace nlo::trainer {

/// Throws codegen::Error if the directory cannot be made or written to, or if it is "-", because stdout is not a
/// folder.
void check_output_directory(const std::string& path);

/// Makes the directory with its parents. Throws codegen::Error if that fails.
void make_output_directory(const std::string& path);

/// A directory that no other nlo can write to while the object exists.
class OutputDirectory {
 public:
  /// Checks, makes and locks the directory. Throws like check_output_directory(), RunFailure if it cannot be made, and
  /// codegen::InputError if another program holds the lock.
  explicit OutputDirectory(const std::string& path);

  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  /// Removes the directories that the constructor has made, if they are still empty.
  ~OutputDirectory();

 private:
  std::vector<std::string> made_;  ///< directories made by the constructor, deepest first
  DirectoryLock lock_;
};

/// Returns true for "-", which stands for stdout in a command that writes one file. Then nothing else is printed there.
bool is_stdout(const std::string& output);

/// Throws codegen::Error if `file` cannot be made: its directory does not exist (unless `makes_folder`: the command
/// makes it), or it is a directory itself. Stdout is always possible.
void check_output_file(const std::string& file, bool makes_folder = false);

/// Makes the folder of `file`. Throws codegen::Error if that fails.
void make_folder_of(const std::string& file);

/// Replaces `file`, or writes to stdout.
void write_output_file(const std::string& file, const std::string& text);

}  // namespace nlo::trainer
