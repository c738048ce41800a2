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

/// Runs the program words[0], found like in a shell, with its arguments in `directory`. Its output goes to log.txt in
/// that directory. With `output`, stdout goes to `output` and only stderr to log.txt. The program is killed after
/// `patience`.
ChildEnd end_of_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience, const std::string& output = "");

/// Runs end_of_child() and returns only the failure; empty on success.
std::string run_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience);

}  // namespace nlo::codegen
