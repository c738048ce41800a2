// SPDX-License-Identifier: MIT
// What is most often wrong with the table of columns, seen from the numbers under it: a dead or doubled sensor, degrees
// called rad, a wrap that is not one, a logged velocity that is no truth. Each finding is a note with its mend.
#pragma once

#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Notes are kept in order and once each: one about a column holds for all logs.
void note_once(std::vector<std::string>& notes, const std::string& text);

/// An angle that jumps and has no wrap; one that turns too fast to be unwrapped. `values` of one run, unwrapped.
void note_suspicious_steps(const LogColumn& column, const Eigen::VectorXd& values, const std::string& file,
                           std::vector<std::string>& notes);

/// Looks at all logs together: a column may well rest in one of them.
void note_suspicious_columns(const LogSchema& schema, const std::vector<LogFile>& logs,
                             std::vector<std::string>& notes);

}  // namespace nlo::trainer
