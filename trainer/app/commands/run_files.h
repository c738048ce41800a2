// SPDX-License-Identifier: MIT
// Runs of a test as files: a picture and a table for each.
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

/// Throws codegen::Error when one cannot be written, or has another ending.
void check_run_files(const RunFiles& files);

/// Writes FILE of the one run that the evaluation has kept, or FILE_1, FILE_2... of several; names the written files on
/// stderr. Throws codegen::Error, without gnuplot when a picture is wanted too.
void write_run_files(const RunFiles& files, const codegen::Model& model, const LogEvaluation& evaluation,
                     bool uniform_steps);

/// run.csv of one, run_1.csv ... run_N.csv of several.
std::string numbered_file(const std::string& file, int index, int count);

}  // namespace nlo::trainer
