// SPDX-License-Identifier: MIT
// Another program, run to its end: no shell between, nothing read from the terminal.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace nlo::codegen {

/// The words of `text`, which blanks part: "gcc -O2" as a program and its arguments.
std::vector<std::string> words_of(const std::string& text);

/// How a program ended.
struct ChildEnd {
  std::string failure;  ///< empty when it ended well, else the reason with the first of what it said
  int exit_code = -1;   ///< -1: it was not started, was killed, or ended by a signal
};

/// Runs `words` (the program, found as a shell would, then its arguments) in `directory`, what it says in log.txt
/// there, or its stdout in `output` and stderr in log.txt. Killed after `patience`.
ChildEnd end_of_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience, const std::string& output = "");

/// The failure alone.
std::string run_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience);

}  // namespace nlo::codegen
