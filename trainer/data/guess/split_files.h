// SPDX-License-Identifier: MIT
// Which logs train, which choose the model and which judge it: whole files, spread over their order.
#pragma once

#include <string>
#include <vector>

namespace nlo::trainer {

struct LogFileSplit {
  std::vector<std::string> all;                      ///< paths, sorted, without copies
  std::string directory;                             ///< above all of them; empty: the current one
  std::vector<std::string> train, validation, test;  ///< below it
};

/// One file trains; of two the second validates; of three to nine the last tests and the one before validates; of more,
/// every fifth tests and the one two before validates. A file that is a copy of another one is left out, and noted.
/// Throws codegen::Error for a name that is no file.
LogFileSplit split_log_files(std::vector<std::string> files, std::vector<std::string>& notes);

}  // namespace nlo::trainer
