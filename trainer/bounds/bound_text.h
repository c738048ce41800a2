// SPDX-License-Identifier: MIT
// The robustness bound as people and programs read it: a table for the terminal, one JSON object, a CSV row per k.
#pragma once

#include <string>
#include <vector>

#include "trainer/bounds/bound_study.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {

/// A table with a column per k: the quantities and, in the second column, their evidence (proven, sampled, assumed,
/// measured, claimed; estimated: a bound made of sampled constants). A row of one cell is the heading of a group.
Table bound_table(const BoundReport& report);

/// What the table comes to, a sentence each: does the measurement keep to the bound, do the steps of the paper's proof
/// hold, is anything infinite and why.
std::vector<std::string> bound_findings(const BoundReport& report);

/// Noise, disturbance, runs, horizon and seed in one line.
std::string bound_conditions(const BoundReport& report);

std::string bound_text(const BoundReport& report);

/// Numbers are finite or null.
std::string bound_json(const BoundReport& report);

std::string bound_csv(const BoundReport& report);

/// On a linear plant: empty, or which measurement broke the bound.
std::string broken_bound(const BoundReport& report);

}  // namespace nlo::trainer
