// SPDX-License-Identifier: MIT
// A comparison as people and programs read it.
#pragma once

#include <string>
#include <vector>

#include "trainer/judge/compare/compare_study.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {

/// The errors, a row for each condition; the least of a row but the floor has a star. Then the worst runs, the tunings
/// and what a step costs.
std::string comparison_text(const Comparison& comparison);

/// One object: "conditions" by name, in each "columns" by name with norm, standard_error, worst; "cost" by column.
std::string comparison_json(const Comparison& comparison);

Table error_table(const Comparison& comparison);
Table worst_table(const Comparison& comparison);
Table tuning_table(const Comparison& comparison);
Table cost_table(const Comparison& comparison);

/// In words: "EKF, tuned", "parameters high". A model keeps its name.
std::string column_title(const CompareColumn& column);
std::string condition_name(const Condition& condition);

/// In how many conditions the first observer errs less than the EKF: one sentence; empty without an EKF.
std::string comparison_summary(const Comparison& comparison);

/// What was compared on what: one sentence.
std::string comparison_conditions(const Comparison& comparison);

/// In words: where the first observer is ahead of the tuned EKF and where not; what has no figure and why.
std::vector<std::string> comparison_findings(const Comparison& comparison);

}  // namespace nlo::trainer
