// SPDX-License-Identifier: MIT
// The numbers of one column over all files of a log, and their properties.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "trainer/data/csv.h"

namespace nlo::trainer {

class ColumnNumbers {
 public:
  /// Reads a column. Leaves out empty cells and the cells that missing() returns: impossible values
  /// (impossible_values.h), and up to three words if more than half of the cells are numbers.
  static ColumnNumbers of(const std::vector<CsvTable>& tables, const std::string& heading, bool is_command);

  /// Returns the stamps of a clock after read_stamps(), in units of the column (times of day: in seconds), one file for
  /// each run between restarts. `notes`: adds notes on single wrong stamps. Throws codegen::Error if the column is not
  /// a clock.
  static ColumnNumbers of_clock(const std::vector<CsvTable>& tables, const std::string& heading,
                                std::vector<std::string>& notes);

  bool is_numeric() const { return is_numeric_; }                ///< else everything below is false or 0
  const std::string& first_cell() const { return first_cell_; }  ///< first cell that is not a number
  /// Returns cells that seem to mean "no value", in the form of the key `missing`. where_missing() gives the place of
  /// the first one.
  const std::vector<std::string>& missing() const { return missing_; }
  const std::string& where_missing() const { return where_missing_; }
  double low() const { return low_; }
  double high() const { return high_; }

  bool is_text() const { return is_text_; }      ///< a clock of times of day
  bool increases() const { return increases_; }  ///< strictly, in each file, without an empty cell
  bool is_even() const;                          ///< increases by steps that are within a tenth of the median
  bool counts_rows() const;                      ///< integers with steps of one
  bool is_constant() const { return is_numeric_ && low_ == high_; }
  bool is_whole() const;
  bool is_copy_of(const ColumnNumbers& other) const;

  struct Steps {
    double median = 0.0, deviation = 0.0, duration = 0.0;  ///< deviation: from an even grid, as a share of the median
  };
  Steps steps() const;  ///< steps of an increasing column

  /// Returns the number of rows from one value to the next, the same in all files (regular_spacing()). 0: a value in
  /// every row, or not regular.
  Eigen::Index spacing() const { return spacing_; }

  const std::vector<Eigen::VectorXd>& files() const { return files_; }

 private:
  std::vector<Eigen::VectorXd> files_;
  bool is_numeric_ = true, increases_ = true, is_text_ = false;
  double low_ = 1.0, high_ = 0.0;
  Eigen::Index spacing_ = 0;
  std::string first_cell_;
  std::vector<std::string> missing_;
  std::string where_missing_;
};

/// The full turn of an angle; 0 if it does not seem to wrap. An angle seems to wrap in two cases:
///   - the column jumps: some steps are larger than half a turn, all these are near a whole turn, and the range is one
///     turn
///   - `unit` is a unit of angles, and the numbers stay within [-1/2, 1/2] or [0, 1] turns, fill half of this range and
///     come near half a turn, so that another run may jump
struct FullTurn {
  double wrap = 0.0;
  std::string unit;    ///< "rad" or "deg", if the angle wraps
  bool jumps = false;  ///< true if a log shows a jump
};
FullTurn full_turn(const ColumnNumbers& numbers, const std::string& unit);

}  // namespace nlo::trainer
