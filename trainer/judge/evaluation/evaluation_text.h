// SPDX-License-Identifier: MIT
// Evaluations as people and programs read them: tables of at most 100 columns for the terminal, JSON for --json.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluate_logs.h"
#include "trainer/judge/evaluation/evaluation_study.h"

namespace nlo::trainer {

/// One row per estimator: norm, nrmse, the norm in each window, settling time and the states' RMSE, with units in the
/// headings; several test sets or models: means with their standard errors. Columns in which no estimator has a value
/// are left out. `is_headed`: above the rows of a condition its noise and runs. For the terminal and the page,
/// as those below.
Table evaluation_table(std::span<const StudyRow> rows, bool is_headed = false);

/// Per state the estimators over the windows, and the cost of their step;
/// the observer per file (no rows where there is one).
Table log_table(const std::vector<LogEntry>& entries, bool with_cost = false);
Table file_table(const LogEvaluation& evaluation);

/// The table under a line that says what was tested, `note` (e.g. "initial states from twice the training box") comes
/// from the caller; below stand the domain and the notes.
std::string evaluation_text(const StudyRow& row, const std::string& note = "");

/// Both tables, then the unscored samples, the domain and the notes.
std::string evaluation_text(const std::string& model, const LogEvaluation& evaluation);

/// One object: norm, nrmse, settled, per_component, settling_time_s, seed, noise of the observer, then facts of the
/// test, then the others under "against". Over several test sets or models these are means, and "standard_error" has
/// theirs. What has no value is null: a number is always finite.
std::string evaluation_json(const StudyRow& row, double box_scale);

/// JSON with these keys over all logs, and the RMSE per state with its unit and per file in each window beside the
/// baselines'.
std::string evaluation_json(const std::string& model, const LogEvaluation& evaluation);

/// Objects as one JSON array.
std::string json_array(const std::vector<std::string>& objects);

}  // namespace nlo::trainer
