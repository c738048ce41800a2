// SPDX-License-Identifier: MIT
// Evaluations for readers and programs: tables of at most 100 columns for the terminal, JSON for --json.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/judge/evaluation/evaluate_logs.h"
#include "trainer/judge/evaluation/evaluation_study.h"

namespace nlo::trainer {

/// Returns one row per estimator: norm, nrmse, the norm in each window, settling time and the RMSE of the states, with
/// units in the headings. For several test sets or models the numbers are means with their standard errors. Columns
/// without any value are left out. `is_headed`: a heading row with noise and runs precedes the rows of each condition.
Table evaluation_table(std::span<const StudyRow> rows, bool is_headed = false);

/// Returns rows for each state: the estimators with their errors in each window and, if `with_cost`, the cost of a
/// step.
Table log_table(const std::vector<LogEntry>& entries, bool with_cost = false);
Table file_table(const LogEvaluation& evaluation);

/// Returns the text for the terminal: a line on the test and `note` (e.g. "initial states from twice the training
/// box"), the table, the domain and the notes.
std::string evaluation_text(const StudyRow& row, const std::string& note = "");

/// Returns the text for the terminal: log_table() and file_table(), the unscored samples, the domain and the notes.
std::string evaluation_text(const std::string& model, const LogEvaluation& evaluation);

/// Returns one object with norm, nrmse, settled, per_component, settling_time_s, seed and noise of the observer, then
/// facts about the test, then the other estimators under "against". For several test sets or models these are means,
/// with their errors in "standard_error". A missing value is null, because numbers are always finite.
std::string evaluation_json(const StudyRow& row, double box_scale);

/// Returns JSON over all logs with the same keys. It also has the RMSE of each state with its unit, and of each file
/// in each window, for the observer and the baselines.
std::string evaluation_json(const std::string& model, const LogEvaluation& evaluation);

/// Returns objects as one JSON array.
std::string json_array(const std::vector<std::string>& objects);

}  // namespace nlo::trainer
