// SPDX-License-Identifier: MIT
// Guesses roles, units, wraps and the clock of a log's columns from headings and numbers. Each guess has a reason.
// Roles that the numbers cannot show (truth that is not measured in flight) stay undecided.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/csv.h"

namespace nlo::trainer {

/// Roles given by the user, as headings or as the names that are made from them.
struct LogHints {
  std::vector<std::string> states, outputs, inputs;
  double period_s = 0.0;  ///< time between rows, if no column is a time; 0: not given
};

struct GuessedColumn {
  std::string heading, name, unit;
  ColumnRole role = ColumnRole::kIgnored;
  bool is_decided = true;     ///< false: the column is ignored until the user chooses its role
  double wrap = 0.0;          ///< full turn, in its unit; 0: not an angle that wraps
  bool jumps = false;         ///< true: the log shows that the angle wraps; false: only unit and range suggest it
  std::string derivative_of;  ///< the output whose derivative this state is
  std::string why;            ///< the reason for the role
  std::vector<std::string> missing;  ///< cells that seem to mean no value
  std::string where_missing;         ///< place of the first such cell and their number
  double low = 0.0, high = 0.0;      ///< range of its numbers; low > high: no numbers
  Eigen::Index spacing = 0;          ///< rows from one value to the next; 0: a value in every row, or not regular
  double period_s = 0.0;             ///< time from one value to the next [s]; 0 also if the clock is not known
};

struct GuessedClock {
  std::string heading, unit;  ///< empty: no column is a time
  double period_s = 0.0;      ///< median step; 0: not known
  double deviation = 0.0;     ///< largest distance of a stamp from an even grid [periods]
  double duration_s = 0.0;    ///< sum over all files
  std::string why;
};

struct GuessedLog {
  CsvFormat format;
  GuessedClock clock;
  std::vector<GuessedColumn> columns;  ///< one for each heading of the first file except the time, then derivatives
  std::string directory;               ///< common folder of all files; empty: the current one
  std::vector<std::string> train, validation, test;  ///< paths relative to `directory`
  Eigen::Index rows = 0;
  std::vector<std::string> notes;

  std::size_t count(ColumnRole role) const;
  std::vector<std::string> undecided() const;  ///< names of columns without a role
};

/// Makes the guess. Throws codegen::Error if a file is not a table of numbers, or if a hint names no column.
GuessedLog guess_log(const std::vector<std::string>& files, const LogHints& hints);

}  // namespace nlo::trainer
