// SPDX-License-Identifier: MIT
// Cells of a log without a value: their places, their replacements, and notes for the user.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Returns the rows of `run`, counted from the first row of the run, whose cell under `heading` is empty. They
/// increase.
std::vector<Eigen::Index> empty_rows(const LogFile& log, const LogRun& run, const std::string& heading);

/// Calls visit(first, last) for each stretch of neighbouring rows; `rows` increase.
template <class Visit>
void for_each_stretch(const std::vector<Eigen::Index>& rows, const Visit& visit) {
  for (std::size_t i = 0, from = 0; i < rows.size(); ++i) {
    if (i + 1 < rows.size() && rows[i + 1] == rows[i] + 1) continue;
    visit(rows[from], rows[i]);
    from = i + 1;
  }
}

/// Replaces the values of `rows` by straight lines between the values around them. At an end of the run the nearest
/// value is held. A run without a value is not changed.
void draw_lines(const std::vector<Eigen::Index>& rows, const Eigen::VectorXd& time_s, Eigen::VectorXd& values);

/// Empty cells of a column over several files.
struct EmptyCells {
  Eigen::Index rows = 0, empty = 0;
  double longest_s = 0.0;  ///< longest time without a value
  std::string worst;       ///< the file with the largest share
  double worst_share = 0.0;
  bool output = false, state = false, input = false;  ///< roles of the column
  double period_s = 0.0;                              ///< period of a slow output in the experiment; else 0
  double regular_s = 0.0;          ///< regular time between two values if period_s is not given, else 0
  Eigen::Index due = 0, lost = 0;  ///< expected and missing samples of a slow output
};

/// Returns the mean number of rows between two values of a column, if it is at least 2 and nine of ten spacings are
/// within a quarter of their median (the others do not count). Otherwise 0. `empty`: rows without a value, increasing.
Eigen::Index regular_spacing(const std::vector<Eigen::Index>& empty, Eigen::Index rows);

/// Adds the columns of `schema` in one more file. If a column has empty cells in one file, its rows in all files are
/// counted.
void count_empty_cells(const LogSchema& schema, const std::vector<LogFile>& logs,
                       std::map<std::string, EmptyCells>& cells);

/// Adds one note for each column with empty cells: their number, the longest stretch, and their replacement.
void note_empty_cells(const std::map<std::string, EmptyCells>& cells, std::vector<std::string>& notes);

}  // namespace nlo::trainer
