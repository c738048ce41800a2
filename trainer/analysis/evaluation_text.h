// SPDX-License-Identifier: MIT
// Evaluations as people and programs read them: tables for the terminal, one JSON object for --json.
#pragma once

#include <string>
#include <vector>

#include "trainer/analysis/evaluate.h"
#include "trainer/analysis/evaluate_logs.h"

namespace nlo::trainer {

/// One row per evaluation: norm, nrmse, settled, settling time and the states' RMSE, with units in the headings. A line
/// above says what was tested; `model` and `note` (e.g. "initial states from twice the training box") come from the
/// caller. All evaluations share test set, noise and seed.
std::string evaluation_text(const std::string& model, const std::vector<Evaluation>& evaluations,
                            const std::string& note = "");

/// Per state: the observer and its alternatives over the three windows; then the observer per file; then the notes.
std::string evaluation_text(const std::string& model, const LogEvaluation& evaluation);

/// One object: norm, nrmse, settled, per_component, settling_time_s, seed, noise of the first evaluation, then facts of
/// the test, then the others under "against". What has no value is null: a number is always finite.
std::string evaluation_json(const std::string& model, const std::vector<Evaluation>& evaluations, double box_scale);

/// The same keys over all logs (norm, nrmse and settled null when the states' units differ), and per state with its
/// unit and per file the RMSE in each window beside the baselines'.
std::string evaluation_json(const std::string& model, const LogEvaluation& evaluation);

}  // namespace nlo::trainer
