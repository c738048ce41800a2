// SPDX-License-Identifier: MIT
// Another program, run to its end: no shell between, nothing read from the terminal.
#pragma once

#include <chrono>
#include <string>
#include <vector>

namespace nlo::codegen {

/// The words of `text`, which blanks part: "gcc -O2" as a program and its arguments.
std::vector<std::string> words_of(const std::string& text);

/// Runs `words` (the program, found as a shell would, then its arguments) in `directory`, what it says in log.txt
/// there. Empty when it ended well, else the reason with the first of that. Killed after `patience`.
std::string run_child(const std::vector<std::string>& words, const std::string& directory,
                      std::chrono::seconds patience);

}  // namespace nlo::codegen
