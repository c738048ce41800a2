// SPDX-License-Identifier: MIT
// A run as an observer had it, sample by sample: to be plotted, to be compared, or to be flown again elsewhere.
#pragma once

#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/evaluation/evaluate.h"

namespace nlo::trainer {

/// CSV with a heading, a row per sample:
///   time              of the run [s]
///   step_s            what step() is told; 0: the sample period
///   OUTPUT...         as measured, angles within half a turn of 0; nan where it is missing
///   INPUT...          as given
///   STATE_estimate... x_hat as it is: of an angle any turn
///   in_domain         1 where z lies in the training domain
///   STATE_truth...    angles within half a turn of 0; nan where it is masked or not known
/// `run` was estimated by `model`, `uniform_steps` as there (evaluate.h).
///   unscored  names of states that the run has no truth of: it then has all_estimates
std::string estimates_csv(const codegen::Model& model, const EvaluatedRun& run, bool uniform_steps,
                          const std::vector<std::string>& unscored = {});

}  // namespace nlo::trainer
