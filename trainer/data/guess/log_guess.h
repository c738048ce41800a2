// SPDX-License-Identifier: MIT
// Guesses roles, units, wraps and the clock of a log's columns from headings and numbers. Each guess has a reason.
// Roles that the numbers cannot show (truth that a system in flight would not have) stay undecided.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/csv.h"

namespace nlo::trainer {

/// Roles given by the user, by headings or by the names that are made from them.
struct LogHints {
  std::vector<std::string> states, outputs, inputs;
  double period_s = 0.0;  ///< between rows, where no column is a time; 0: not said
};

struct GuessedColumn {
  std::string heading, name, unit;
  ColumnRole role = ColumnRole::kIgnored;
  bool is_decided = true;            ///< false: ignored until the user chooses its role
  double wrap = 0.0;                 ///< full turn, in its unit; 0: no angle that wraps
  bool jumps = false;                ///< the log shows that it wraps; else unit and range alone tell
  std::string derivative_of;         ///< a state that is the derivative of this output
  std::string why;                   ///< the reason for the role
  std::vector<std::string> missing;  ///< cells that seem to stand for no value
  std::string where_missing;         ///< the first of them, and how many there are
  double low = 0.0, high = 0.0;      ///< range of its numbers; low > high: it has none
  Eigen::Index spacing = 0;          ///< rows from one value to the next; 0: it has one in every row, or not regularly
  double period_s = 0.0;             ///< the same in seconds; 0, too, where no clock is known
};

struct GuessedClock {
  std::string heading, unit;  ///< empty: no column is a time
  double period_s = 0.0;      ///< median step; 0: not known
  double deviation = 0.0;     ///< largest distance of a stamp from an even grid, in periods
  double duration_s = 0.0;    ///< sum over all files
  std::string why;
};

struct GuessedLog {
  CsvFormat format;
  GuessedClock clock;
  std::vector<GuessedColumn> columns;  ///< one for each heading of the first file but the time, then derivatives
  std::string directory;               ///< above all files; empty: the current one
  std::vector<std::string> train, validation, test;  ///< below it
  Eigen::Index rows = 0;
  std::vector<std::string> notes;

  std::size_t count(ColumnRole role) const;
  std::vector<std::string> undecided() const;  ///< names
};

/// Throws codegen::Error where a file is no table of numbers, or a hint names no column.
GuessedLog guess_log(const std::vector<std::string>& files, const LogHints& hints);

}  // namespace nlo::trainer
