// SPDX-License-Identifier: MIT
// A log as numbers: the columns that an experiment lists, its clock, and the runs between its gaps. Read once; the
// channels of a Dataset and every check of the logs come from here.
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

/// A stretch of a log without a gap.
struct LogRun {
  std::string source;  ///< "run3.csv", or "run3.csv (2 of 3)"
  Eigen::Index first = 0, rows = 0;
  Eigen::VectorXd time_s;  ///< from its first sample, as stamped
  TimeGrid grid;
};

struct LogFile {
  std::string path, name;  ///< name: without its folders
  /// By heading, as they stand in the file. An empty cell holds the last value above it, and the first below it where
  /// there is none above.
  std::map<std::string, Eigen::VectorXd> columns;
  std::map<std::string, std::vector<Eigen::Index>> empty;  ///< by heading, rows of its empty cells; none: not listed
  Eigen::VectorXd time_s;                                  ///< from the first sample, increasing (log_stamps.h)
  std::vector<Eigen::Index> restarts;                      ///< rows at which the clock has gone back: runs begin there
  double start_s = 0.0;                                    ///< its first stamp; 0: no time column
  double resolution_s = 0.0;             ///< resolution of the printed stamps; 0: none, or no time column
  bool has_time_unit = false;            ///< else its stamps are taken for seconds
  std::vector<std::string> clock_notes;  ///< notes on single wrong stamps
  std::vector<int> lines;                ///< line of each row in the file
  std::vector<std::string> needed;       ///< headings of outputs and inputs: a run begins where all have values

  const Eigen::VectorXd& column(const std::string& heading) const { return columns.at(heading); }
  /// In the unit of the column. What stands in the file goes through unchanged where nothing converts it.
  Eigen::VectorXd values(const LogColumn& column) const;
};

/// Reads the columns that `schema` lists. Throws codegen::Error naming file, line and column: see CsvTable and
/// read_stamps; fewer than two samples; columns without any value, beside the shares of all that are mostly empty.
LogFile read_log(const std::string& path, const LogSchema& schema, double sample_period_s);

/// The runs between restarts of the clock and steps longer than `max_gap_s`, which `notes` name, beside single wrong
/// stamps. Rows at the start of a run are left out until every output and input has had a value. Runs of
/// one sample are dropped, and noted.
std::vector<LogRun> split_at_gaps(const LogFile& log, double max_gap_s, std::vector<std::string>& notes);

/// Headings of all listed columns except time, each once, in the order of the list.
std::vector<std::string> listed_headings(const LogSchema& schema);

}  // namespace nlo::trainer
