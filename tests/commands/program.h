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

  /// Returns every file in the directory with its bytes, and every folder (with a trailing slash).
  std::map<std::string, std::string> contents() const;

  /// Runs the program here. Kills it after five minutes, because a busy machine may be slow. `interrupt_at`: sends
  /// Ctrl-C when its stderr contains these words.
  ProgramResult run(const std::vector<std::string>& arguments, const std::string& interrupt_at = "") const;
  /// Runs a command that must succeed; otherwise the test fails and ends.
  ProgramResult ok(const std::vector<std::string>& arguments) const;
  /// Runs a command that must end with `exit_code` and returns its error.
  std::string refusal(int exit_code, const std::vector<std::string>& arguments) const;
  /// Like run(), for another program.
  ProgramResult run_program(const std::string& program, const std::vector<std::string>& arguments,
                            const std::string& interrupt_at = "") const;
};

/// An experiment with a plant that trains quickly, and one on logs.
extern const std::string kTinyExperiment;
extern const std::string kTinyLogExperiment;

/// Returns a log for kTinyLogExperiment: y = sin t at 100 Hz, without a column for the velocity of y.
std::string tiny_log(double phase = 0.0, int samples = 300);

/// Returns `text` with the only occurrence of `old` replaced; fails the test if `old` is missing.
std::string with(std::string text, const std::string& old, const std::string& replacement);

}  // namespace nlo::trainer
