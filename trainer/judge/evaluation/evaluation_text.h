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
/// units in the headings. For several test sets or models: means with their standard errors. Columns without any value
/// are left out. `is_headed`: a line with noise and runs is above the rows of a condition. For the terminal and the
/// page, like the next functions.
Table evaluation_table(std::span<const StudyRow> rows, bool is_headed = false);

/// Returns for each state the estimators over the windows, and the cost of their step; then the observer per file (no
/// rows for a single file).
Table log_table(const std::vector<LogEntry>& entries, bool with_cost = false);
Table file_table(const LogEvaluation& evaluation);

/// Returns the table with a line above it on the test and `note` (e.g. "initial states from twice the training box");
/// below it the domain and the notes.
std::string evaluation_text(const StudyRow& row, const std::string& note = "");

/// Returns both tables, then the unscored samples, the domain and the notes.
std::string evaluation_text(const std::string& model, const LogEvaluation& evaluation);

/// Returns one object: norm, nrmse, settled, per_component, settling_time_s, seed, noise of the observer, then facts
/// about the test, then the other estimators under "against". For several test sets or models these are means, with
/// their errors in "standard_error". A missing value is null, because numbers are always finite.
std::string evaluation_json(const StudyRow& row, double box_scale);

/// Returns JSON with these keys over all logs. It also has the RMSE per state with its unit and per file in each
/// window, for the observer and the baselines.
std::string evaluation_json(const std::string& model, const LogEvaluation& evaluation);

/// Returns objects as one JSON array.
std::string json_array(const std::vector<std::string>& objects);

}  // namespace nlo::trainer
