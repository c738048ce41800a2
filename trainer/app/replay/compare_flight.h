// SPDX-License-Identifier: MIT
// Compares a recorded flight with its replay, number by number.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

#include "trainer/app/replay/flight_log.h"

namespace nlo::trainer {

/// The first difference between a flight and its replay.
struct FlightDifference {
  Eigen::Index row = 0;
  const LoggedColumn* column = nullptr;
  Eigen::Index rows = 0;  ///< number of rows that differ in any column
};

class FlightComparison {
 public:
  /// `single`: the export calculates with floats.
  FlightComparison(const FlightLog& log, bool single) : log_(log), single_(single) {}

  /// Returns true if `answer` equals the logged value in `row`, bit for bit or to the printed digits, or if nothing was
  /// logged.
  bool same(const LoggedColumn& column, Eigen::Index row, double answer) const;

  /// Returns the column of the log that differs from `answers`, the answers at this row; null: none differs.
  const LoggedColumn* difference(Eigen::Index row, const Eigen::Ref<const Eigen::VectorXd>& answers) const;

  /// Returns the first difference in the order of the rows; nothing if there is none.
  std::optional<FlightDifference> first(const Eigen::MatrixXd& answers) const;

  /// Returns the number of cells that agree only to their printed digits.
  Eigen::Index rounded(const Eigen::MatrixXd& answers) const;

  /// Returns the distance of two values in steps from one representable value of the scalar to the next.
  double units(double logged, double answer) const;

  /// Returns the digits that distinguish all numbers of the scalar.
  int digits_needed() const { return single_ ? 9 : 17; }

 private:
  double exact(double value) const { return single_ ? static_cast<double>(static_cast<float>(value)) : value; }

  const FlightLog& log_;
  bool single_;
};

/// Returns a number with all its digits.
std::string all_digits(double value, bool single);

}  // namespace nlo::trainer
