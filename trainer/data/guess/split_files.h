// SPDX-License-Identifier: MIT
// Splits logs into files for training, for the choice of the model, and for tests: whole files, spread over their
// order.
#pragma once

#include <string>
#include <vector>

namespace nlo::trainer {

struct LogFileSplit {
  std::vector<std::string> all;                      ///< paths, sorted, without copies
  std::string directory;                             ///< common folder of all files; empty: the current one
  std::vector<std::string> train, validation, test;  ///< paths relative to `directory`
};

/// Splits the files by their number. One file: training. Two files: the second is for validation. Three to nine files:
/// the last is for the test, the one before it for validation. More files: every fifth is for the test, and the file
/// two places before it for validation. A copy of another file is left out, with a note. Throws codegen::Error for a
/// name that is not a file.
LogFileSplit split_log_files(std::vector<std::string> files, std::vector<std::string>& notes);

}  // namespace nlo::trainer
