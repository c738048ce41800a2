// SPDX-License-Identifier: MIT
// The result of a run in a few sentences and numbers: the top of its page.
#pragma once

#include <string>
#include <vector>

#include "trainer/app/report/report.h"

namespace nlo::trainer {

/// The group that speaks for the whole: the first with Gaussian noise, else with any, else the first.
/// Null: there is none.
const std::vector<Evaluation>* main_group(const std::vector<std::vector<Evaluation>>& groups);

/// Plain text. `group`: the observer and its alternatives under one noise.
std::string plant_summary(const std::vector<Evaluation>& group);
std::string log_summary(const LogEvaluation& logs);

/// HTML: the numbers that matter most, large. Empty: there are none.
std::string tiles(const ReportData& data);

}  // namespace nlo::trainer
