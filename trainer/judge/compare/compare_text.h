// SPDX-License-Identifier: MIT
// A comparison as text for readers and as JSON for programs.
#pragma once

#include <string>
#include <vector>

#include "trainer/judge/compare/study.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

/// Returns the errors, a row for each condition; the smallest of a row except the floor has a star. The worst runs, the
/// tunings and the cost of a step follow.
std::string comparison_text(const Study& study);

/// Returns one object: "conditions" by name, each with "columns" by name with norm, standard_error, worst; "cost" by
/// column.
std::string comparison_json(const Study& study);

Table error_table(const Study& study);
Table worst_table(const Study& study);
Table tuning_table(const Study& study);
Table cost_table(const Study& study);

/// Returns the title in words: "EKF, tuned", "parameters high". A model keeps its name.
std::string column_title(const StudyEstimator& estimator);
std::string condition_name(const Condition& condition);

/// Returns one sentence on the number of conditions in which the first observer has a smaller error than the EKF; empty
/// without an EKF.
std::string comparison_summary(const Study& study);

/// Describes the comparison and its conditions in one sentence.
std::string comparison_conditions(const Study& study);

/// Returns sentences on the conditions in which the first observer is better or worse than the tuned EKF, and on
/// missing figures with their reasons.
std::vector<std::string> comparison_findings(const Study& study);

}  // namespace nlo::trainer
