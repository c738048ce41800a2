// SPDX-License-Identifier: MIT
// Runs `nlo` in a scratch directory and reads its output and its files.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/support/scratch_directory.h"

namespace nlo::trainer {

struct ProgramResult {
  int exit_code = -1;  ///< -1: killed by a signal
  std::string out, err;
  double peak_mb = 0.0;  ///< largest memory in use, at least that of the test before it started the program
};

/// A directory to run programs in.
class Scratch : public ScratchDirectory {
 public:
  bool has(const std::string& file) const;

  /// Every file below it with its bytes, and every folder (with a trailing slash).
  std::map<std::string, std::string> contents() const;

  /// Runs the program here. It is killed after five minutes: a busy machine takes long for little.
  /// `interrupt_at`: Ctrl-C once its stderr has these words.
  ProgramResult run(const std::vector<std::string>& arguments, const std::string& interrupt_at = "") const;
  /// One that must succeed: the test fails and ends where it does not.
  ProgramResult ok(const std::vector<std::string>& arguments) const;
  /// The error of one that must end with `exit_code`.
  std::string refusal(int exit_code, const std::vector<std::string>& arguments) const;
  /// run() of another program.
  ProgramResult run_program(const std::string& program, const std::vector<std::string>& arguments,
                            const std::string& interrupt_at = "") const;
};

/// A plant experiment that trains in a moment, and one on logs.
extern const std::string kTinyExperiment;
extern const std::string kTinyLogExperiment;

/// A log for it: y = sin t at 100 Hz with its velocity's column left out.
std::string tiny_log(double phase = 0.0, int samples = 300);

/// `text` with its one occurrence of `old` replaced; fails the test when there is none.
std::string with(std::string text, const std::string& old, const std::string& replacement);

}  // namespace nlo::trainer
