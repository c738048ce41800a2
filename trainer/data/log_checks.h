// SPDX-License-Identifier: MIT
// Finds frequent mistakes in the table of columns from the numbers: a dead or doubled sensor, degrees called rad, a
// wrong wrap, a logged velocity that is no truth. Each finding is a note with its remedy.
#pragma once

#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Steps of a column, over the runs of one file.
struct SuspiciousSteps {
  const LogColumn* column = nullptr;
  Eigen::Index wide = 0;  ///< by more than a third of a turn, of an angle with a wrap
};

/// Adds the steps of `values`, which are of one run, unwrapped.
void count_suspicious_steps(const LogColumn& column, const Eigen::VectorXd& values,
                            std::vector<SuspiciousSteps>& found);

/// An angle that turns too fast to be unwrapped.
void note_suspicious_steps(const std::vector<SuspiciousSteps>& found, const std::string& file,
                           std::vector<std::string>& notes);

/// Stamps that are read as seconds for want of a unit, and would be a log of a second or more per row, over hundreds of
/// rows; or stamps that lie beyond the year 5000: a unit that fits better. Empty where nothing is to be said.
std::string time_unit_doubt(const LogSchema& schema, const LogConfig& config, const std::vector<LogFile>& logs);

/// Looks at all logs together: a column may well rest in one of them.
void note_suspicious_columns(const LogSchema& schema, const std::vector<LogFile>& logs,
                             std::vector<std::string>& notes);

}  // namespace nlo::trainer
