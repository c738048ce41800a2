// SPDX-License-Identifier: MIT
// Writes runs of a test as files: a figure and a table for each.
#pragma once

#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/judge/evaluation/evaluate_logs.h"

namespace nlo::trainer {

struct RunFiles {
  std::string figure, estimates;  ///< FILE.svg and FILE.csv; empty: none

  bool any() const { return !figure.empty() || !estimates.empty(); }
};

/// Throws codegen::Error if a file cannot be written or has another ending.
void check_run_files(const RunFiles& files);

/// Writes FILE for the single run that the evaluation has kept, or FILE_1, FILE_2... for several, and prints the names
/// on stderr. Throws codegen::Error, also if gnuplot is missing and a figure is wanted.
void write_run_files(const RunFiles& files, const codegen::Model& model, const LogEvaluation& evaluation,
                     bool uniform_steps);

/// Returns run.csv for one run, run_1.csv ... run_N.csv for several.
std::string numbered_file(const std::string& file, int index, int count);

}  // namespace nlo::trainer
