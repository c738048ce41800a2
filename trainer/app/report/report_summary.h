// SPDX-License-Identifier: MIT
// The result of a run in a few sentences and numbers: the top of its page.
#pragma once

#include <string>
#include <vector>

#include "trainer/app/report/report.h"

namespace nlo::trainer {

/// The row that speaks for the whole: the first with Gaussian noise, else with any, else the first.
/// Null: there is none.
const StudyRow* main_row(const std::vector<StudyRow>& rows);

/// Plain text.
std::string plant_summary(const StudyRow& row);
std::string log_summary(const LogEvaluation& logs);

/// HTML: the numbers that matter most, large. Empty: there are none.
std::string tiles(const ReportData& data);

}  // namespace nlo::trainer
