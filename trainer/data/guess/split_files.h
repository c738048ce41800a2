// SPDX-License-Identifier: MIT
// Splits logs into files for training, for the choice of the model, and for tests: whole files, by their names or
// spread over their order.
#pragma once

#include <string>
#include <vector>

namespace nlo::trainer {

struct LogFileSplit {
  std::vector<std::string> all;                      ///< paths, sorted, without copies
  std::string directory;                             ///< common folder of all files; empty: the current one
  std::vector<std::string> train, validation, test;  ///< paths relative to `directory`
};

/// Splits the files by words of their names and folders: "test" or "testing"; "validation", "validate", "valid" or
/// "val". The other files, or all if each has such a word, are split by their number. Up to nine files: the last is for
/// the test if there are three or more, and the last of the rest for validation if there are two or more. More files:
/// every fifth is for the test, and the file two places before it for validation. If a word has given files to the test
/// or to the validation, no others are added. A copy of another file is left out, with a note. Throws codegen::Error
/// for a name that is not a file.
LogFileSplit split_log_files(std::vector<std::string> files, std::vector<std::string>& notes);

}  // namespace nlo::trainer
