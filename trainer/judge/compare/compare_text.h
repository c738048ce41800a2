// SPDX-License-Identifier: MIT
// A comparison as people and programs read it.
#pragma once

#include <string>
#include <vector>

#include "trainer/judge/compare/study.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

/// The errors, a row for each condition; the least of a row but the floor has a star. Then the worst runs, the tunings
/// and the cost of a step.
std::string comparison_text(const Study& study);

/// One object: "conditions" by name, in each "columns" by name with norm, standard_error, worst; "cost" by column.
std::string comparison_json(const Study& study);

Table error_table(const Study& study);
Table worst_table(const Study& study);
Table tuning_table(const Study& study);
Table cost_table(const Study& study);

/// In words: "EKF, tuned", "parameters high". A model keeps its name.
std::string column_title(const StudyEstimator& estimator);
std::string condition_name(const Condition& condition);

/// In how many conditions the first observer errs less than the EKF: one sentence; empty without an EKF.
std::string comparison_summary(const Study& study);

/// Describes the comparison and its conditions in one sentence.
std::string comparison_conditions(const Study& study);

/// In words: where the first observer is ahead of the tuned EKF and where not; missing figures and the reasons.
std::vector<std::string> comparison_findings(const Study& study);

}  // namespace nlo::trainer
