// SPDX-License-Identifier: MIT
// Runs another program to its end, without a shell and without input from the terminal.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace nlo::codegen {

/// Splits `text` at blanks: "gcc -O2" becomes a program and its arguments.
std::vector<std::string> words_of(const std::string& text);

/// Result of a program.
struct ChildEnd {
  std::string failure;  ///< empty on success, else the reason and the first lines of its output
  int exit_code = -1;   ///< -1: not started, killed, or ended by a signal
};

/// Runs `words` in `directory`: the program, which is found as by a shell, and its arguments. Its output goes to
/// log.txt in that directory; with `output`, stdout goes there and only stderr to log.txt. The program is killed after
/// `patience`.
ChildEnd end_of_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience, const std::string& output = "");

/// Returns the failure alone.
std::string run_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience);

}  // namespace nlo::codegen
