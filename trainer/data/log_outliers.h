// SPDX-License-Identifier: MIT
// Finds single rows of a log's truth that no motion explains.
#pragma once

#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Finds rows of a state that are far away for a moment: at most kOutlierRows rows that leave all others by more than
/// their range and return (see is_outlier in log_outliers.cpp). Adds a note for each state: their number, and the
/// farthest with its file, line and value. An observer would learn them as truth.
void note_outliers(const LogSchema& schema, const std::vector<LogFile>& logs, std::vector<std::string>& notes);
inline constexpr Eigen::Index kOutlierRows = 5;

}  // namespace nlo::trainer
