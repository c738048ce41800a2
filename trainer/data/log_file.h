// SPDX-License-Identifier: MIT
// A log as numbers: the columns of an experiment, its clock, and the runs between its gaps. It is read once; the
// channels of a Dataset and all checks of logs use it.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "trainer/data/log_schema.h"
#include "trainer/data/time_stamps.h"

namespace nlo::trainer {

/// A column with a larger share of empty cells is mostly empty.
inline constexpr double kMostlyEmpty = 0.5;

/// A part of a log without a gap.
struct LogRun {
  std::string source;  ///< "run3.csv", or "run3.csv (2 of 3)"
  Eigen::Index first = 0, rows = 0;
  Eigen::VectorXd time_s;  ///< stamps from its first sample on
  TimeGrid grid;
};

struct LogFile {
  std::string path, name;  ///< name: without folders
  /// Columns by heading, with the numbers of the file. An empty cell holds the last value above it, or the first value
  /// below it if there is none above.
  std::map<std::string, Eigen::VectorXd> columns;
  std::map<std::string, std::vector<Eigen::Index>> empty;  ///< by heading: rows of its empty cells; a column without
                                                           ///< empty cells is not listed
  Eigen::VectorXd time_s;                                  ///< from the first sample, increasing (log_stamps.h)
  std::vector<Eigen::Index> restarts;                      ///< rows at which the clock has gone back: runs begin there
  double start_s = 0.0;                                    ///< first stamp; 0 without a time column
  double resolution_s = 0.0;             ///< resolution of the printed stamps; 0: unknown, or no time column
  bool has_time_unit = false;            ///< false: stamps are assumed to be in seconds
  std::vector<std::string> clock_notes;  ///< notes on single wrong stamps
  std::vector<int> lines;                ///< line of each row in the file
  std::vector<std::string> needed;       ///< headings of outputs and inputs; a run begins when all have values

  const Eigen::VectorXd& column(const std::string& heading) const { return columns.at(heading); }
  /// Returns the values in the unit of the column. Without a conversion they are the numbers of the file.
  Eigen::VectorXd values(const LogColumn& column) const;
};

/// Reads the columns that `schema` lists. Throws codegen::Error with file, line and column: see CsvTable and
/// read_stamps; for fewer than two samples; for columns without any value (with the shares of all columns that are
/// mostly empty).
LogFile read_log(const std::string& path, const LogSchema& schema, double sample_period_s);

/// Returns the runs between restarts of the clock and steps longer than `max_gap_s`. `notes` names these places and
/// single wrong stamps. Rows at the start of a run are left out until every output and input has had a value. Runs of
/// one sample are dropped, with a note.
std::vector<LogRun> split_at_gaps(const LogFile& log, double max_gap_s, std::vector<std::string>& notes);

/// Returns the headings of all listed columns except time, each once, in the order of the list.
std::vector<std::string> listed_headings(const LogSchema& schema);

}  // namespace nlo::trainer
