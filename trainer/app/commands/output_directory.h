// SPDX-License-Identifier: MIT
// The output directory of a command. It is checked before anything is computed and created only when there is
// something to write.
#pragma once

#include <string>
#include <vector>

#include "trainer/app/commands/directory_lock.h"

namespace nlo::trainer {

/// Throws codegen::Error when the directory cannot be made or written to, or when it is "-": stdout is no folder.
void check_output_directory(const std::string& path);

/// Makes the directory with its parents. Throws codegen::Error.
void make_output_directory(const std::string& path);

/// A directory that no other nlo writes to as long as the object lives.
class OutputDirectory {
 public:
  /// Checks the directory, makes it and locks it. Throws as check_output_directory() does, RunFailure when it cannot be
  /// made, codegen::InputError while another program holds the lock.
  explicit OutputDirectory(const std::string& path);

  OutputDirectory(const OutputDirectory&) = delete;
  OutputDirectory& operator=(const OutputDirectory&) = delete;

  /// Removes the directories that the constructor made if nothing was written into them.
  ~OutputDirectory();

 private:
  std::vector<std::string> made_;  ///< by the constructor, the deepest first
  DirectoryLock lock_;
};

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
