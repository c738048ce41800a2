// SPDX-License-Identifier: MIT
// What is most often wrong with the table of columns, seen from the numbers under it: a dead or doubled sensor, degrees
// called rad, a wrap that is not one, a logged velocity that is no truth. Each finding is a note with its fix.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Notes are kept in order and once each: one about a column holds for all logs.
void note_once(std::vector<std::string>& notes, const std::string& text);

/// Cells of a column that hold no value, over several files.
struct EmptyCells {
  Eigen::Index rows = 0, empty = 0;
  double longest_s = 0.0;  ///< stretch without a value
  std::string worst;       ///< the file with the largest share
  double worst_share = 0.0;
  bool output = false, state = false, input = false;  ///< what the column is
};

/// Adds the columns of `schema` in one more file. Once a column has empty cells, its rows in all files count.
void count_empty_cells(const LogSchema& schema, const std::vector<LogFile>& logs,
                       std::map<std::string, EmptyCells>& cells);

/// One note for each column with empty cells: how many, the longest stretch, and what becomes of them.
void note_empty_cells(const std::map<std::string, EmptyCells>& cells, std::vector<std::string>& notes);

/// Steps of a column, over the runs of one file.
struct SuspiciousSteps {
  const LogColumn* column = nullptr;
  Eigen::Index jumps = 0;  ///< by more than half a turn, of an angle without a wrap
  Eigen::Index wide = 0;   ///< by more than a third of a turn, of one with a wrap
};

/// Adds the steps of `values`, which are of one run, unwrapped.
void count_suspicious_steps(const LogColumn& column, const Eigen::VectorXd& values,
                            std::vector<SuspiciousSteps>& found);

/// An angle that jumps and has no wrap; one that turns too fast to be unwrapped.
void note_suspicious_steps(const std::vector<SuspiciousSteps>& found, const std::string& file,
                           std::vector<std::string>& notes);

/// Rows of a state that stand far off for a moment: at most kOutlierRows rows that leave all others by more than their
/// range and come back (see is_outlier in log_checks.cpp). A note for each state: how many, and the farthest with its file,
/// line and value. An observer would learn them as truth.
void note_outliers(const LogSchema& schema, const std::vector<LogFile>& logs, std::vector<std::string>& notes);
inline constexpr Eigen::Index kOutlierRows = 5;

/// Stamps that are read as seconds for want of a unit, and would be a log of a second or more per row, over hundreds of
/// rows; or stamps that lie beyond the year 5000: a unit that fits better. Empty where nothing is to be said.
std::string time_unit_doubt(const LogSchema& schema, const LogConfig& config, const std::vector<LogFile>& logs);

/// Looks at all logs together: a column may well rest in one of them.
void note_suspicious_columns(const LogSchema& schema, const std::vector<LogFile>& logs,
                             std::vector<std::string>& notes);

}  // namespace nlo::trainer
