// SPDX-License-Identifier: MIT
// Finds frequent mistakes in the table of columns from the numbers: a dead sensor, two copies of one sensor, the wrong
// unit of an angle, a wrong wrap, a logged velocity that is not the truth. Each finding is a note with its remedy.
#pragma once

#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Steps of a column, over the runs of one file.
struct SuspiciousSteps {
  const LogColumn* column = nullptr;
  Eigen::Index wide = 0;  ///< number of steps of more than a third of a turn, for an angle with a wrap
};

/// Adds the steps of `values`, one unwrapped run.
void count_suspicious_steps(const LogColumn& column, const Eigen::VectorXd& values,
                            std::vector<SuspiciousSteps>& found);

/// Adds a note for an angle that turns too fast to be unwrapped.
void note_suspicious_steps(const std::vector<SuspiciousSteps>& found, const std::string& file,
                           std::vector<std::string>& notes);

/// Returns a note about time stamps that have no unit and are therefore read as seconds, if the log then has a second
/// or more per row over hundreds of rows, or if stamps are beyond the year 5000. Empty if there is no doubt.
std::string time_unit_doubt(const LogSchema& schema, const LogConfig& config, const std::vector<LogFile>& logs);

/// Checks all logs together, because a column may be constant in one of them.
void note_suspicious_columns(const LogSchema& schema, const std::vector<LogFile>& logs,
                             std::vector<std::string>& notes);

}  // namespace nlo::trainer
