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
  /// Leaves out empty cells and the cells that missing() names: impossible values (impossible_values.h), and up to
  /// three words where more than half of the cells are numbers.
  static ColumnNumbers of(const std::vector<CsvTable>& tables, const std::string& heading, bool is_command);

  /// The stamps of a clock as read_stamps() cleans them, in units of the column (times of day: in seconds), a file for
  /// each run between restarts. `notes`: adds notes on single wrong stamps. Throws codegen::Error if the column is
  /// no clock.
  static ColumnNumbers of_clock(const std::vector<CsvTable>& tables, const std::string& heading,
                                std::vector<std::string>& notes);

  bool is_numeric() const { return is_numeric_; }                ///< else everything below is false or 0
  const std::string& first_cell() const { return first_cell_; }  ///< first cell that is no number
  /// Cells that seem to stand for no value, as the key `missing` has them, and where the first is; empty: none.
  const std::vector<std::string>& missing() const { return missing_; }
  const std::string& where_missing() const { return where_missing_; }
  double low() const { return low_; }
  double high() const { return high_; }

  bool is_text() const { return is_text_; }      ///< a clock of times of day
  bool increases() const { return increases_; }  ///< strictly, in each file, without an empty cell
  bool is_even() const;                          ///< increasing by steps that are within a tenth of the median
  bool counts_rows() const;                      ///< whole numbers, one apart
  bool is_constant() const { return is_numeric_ && low_ == high_; }
  bool is_whole() const;
  bool is_copy_of(const ColumnNumbers& other) const;

  struct Steps {
    double median = 0.0, deviation = 0.0, duration = 0.0;  ///< deviation: from an even grid, in medians
  };
  Steps steps() const;  ///< steps where it increases

  /// Rows from one value to the next, the same in all files (regular_spacing()); 0: in every row, or not regular.
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

/// The full turn of an angle, 0 where it does not seem to wrap. Either it jumps back: every step of more than half a
/// turn, one at least, is near a whole one, and the range is one turn. Or `unit` is that of an angle, and its numbers
/// stay in one turn, from -1/2 or from 0 on, fill half of it and come near half a turn: then another run may jump.
struct FullTurn {
  double wrap = 0.0;
  std::string unit;    ///< "rad", "deg", where it wraps
  bool jumps = false;  ///< else no log shows a jump
};
FullTurn full_turn(const ColumnNumbers& numbers, const std::string& unit);

}  // namespace nlo::trainer
