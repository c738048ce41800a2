// SPDX-License-Identifier: MIT
// The result of a run in a few sentences and numbers: the beginning of its page.
#pragma once

#include <string>
#include <vector>

#include "trainer/app/report/report.h"

namespace nlo::trainer {

/// Returns the row for the summary: the first with Gaussian noise, otherwise the first with any noise, otherwise the
/// first. Null: there is no row.
const StudyRow* main_row(const std::vector<StudyRow>& rows);

/// Returns plain text.
std::string plant_summary(const StudyRow& row);
std::string log_summary(const LogEvaluation& logs);

/// Returns HTML: the most important numbers in large type. Empty if there are none.
std::string tiles(const ReportData& data);

}  // namespace nlo::trainer
