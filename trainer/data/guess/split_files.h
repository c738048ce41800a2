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
  std::vector<std::string> train, validation, test;  ///< paths relative to it
};

/// One file trains. Of two, the second validates. Of three to nine, the last tests and the one before validates. Of
/// more, every fifth tests, and the file two places before it validates. A file that is a copy of another one is left
/// out, with a note. Throws codegen::Error for a name that is not a file.
LogFileSplit split_log_files(std::vector<std::string> files, std::vector<std::string>& notes);

}  // namespace nlo::trainer
