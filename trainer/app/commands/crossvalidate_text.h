// SPDX-License-Identifier: MIT
// The output of nlo crossvalidate about its trainings.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "trainer/data/log_files.h"
#include "trainer/judge/evaluation/evaluate_logs.h"

namespace nlo::trainer {

/// The result of one training on `logs` logs for a fold.
struct FoldOutcome {
  std::string fold;
  int logs = 0;
  unsigned long long seed = 0;
  std::map<std::string, std::vector<StateError>> errors;  ///< by estimator, over all samples of the fold
};

/// Returns a row for each fold with the mean over seeds; below it all folds together.
std::string fold_table(const std::vector<FoldOutcome>& outcomes, const std::vector<LogGroup>& folds, int seeds);

/// Returns a row for each number of training logs: mean over folds and seeds.
std::string curve_table(const std::vector<FoldOutcome>& outcomes, const std::vector<int>& sizes);

/// Returns an object for each training.
std::string crossvalidation_json(const std::vector<FoldOutcome>& outcomes);

}  // namespace nlo::trainer
