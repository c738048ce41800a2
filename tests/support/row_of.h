// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include "trainer/judge/evaluation/evaluation_study.h"

namespace nlo::trainer {

/// Returns a row of a report for one model, with its evaluations on one test set.
inline StudyRow row_of(const std::string& model, const std::vector<Evaluation>& evaluations) {
  StudyRow row{{model}, {}};
  for (const Evaluation& evaluation : evaluations) row.cells.push_back({{{evaluation}}});
  return row;
}

}  // namespace nlo::trainer
