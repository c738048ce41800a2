// SPDX-License-Identifier: MIT
// Finds numbers that a logger writes in place of a missing reading: -9999, 65535, the largest float. One such sample in
// a hundred ruins a training.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

struct ImpossibleValues {
  std::vector<double> values;    ///< most frequent first; empty: none
  Eigen::Index count = 0;        ///< number of samples with one of `values`
  Eigen::Index all = 0;          ///< number of all samples
  std::size_t file = 0;          ///< file of the first such sample
  Eigen::Index row = 0;          ///< row of the first such sample
  double low = 0.0, high = 0.0;  ///< range of the other samples
};

/// Finds the isolated values of a column: they are far outside of all other samples, with nothing in between. `range`
/// is the range of the others. "Brief" means at most 5 rows in a row, "rare" less than 20 % of the rows (any other
/// value: 5 %). "Far" means that the distance to the others exceeds the given number of ranges.
///   beyond 1e30                                      always
///   -99, -999, -9999, ... (nines)                    far: 0.3 ranges, or 3 if the column has few different values
///   ends of converters and of integers, 999, 9999    brief and far: 0.3 ranges; or rare and far: 3 ranges
///   any other value, unless the column is a command  brief, rare, at three places, and far: 3 ranges
/// Returns none if half of the samples or more would be impossible. `signals`: the column in each log; NaN does not
/// count.
ImpossibleValues impossible_values(const std::vector<Eigen::VectorXd>& signals, bool is_command);

/// Returns a text: FILE:LINE: "HEADING" is -9999 here and in 1 % of its rows; elsewhere it is from -3 to 3.
std::string to_text(const ImpossibleValues& found, const std::string& heading, const std::string& file, int line);

/// Returns the values in the form of the key `missing`.
std::vector<std::string> as_cells(const ImpossibleValues& found);

/// Adds a note for each output, input and state that has such values, with the key that makes them missing. Returns the
/// headings.
std::vector<std::string> note_impossible_values(const LogSchema& schema, const std::vector<LogFile>& logs,
                                                std::vector<std::string>& notes);

}  // namespace nlo::trainer
