// SPDX-License-Identifier: MIT
// A recorded flight held against its replay, number by number.
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
  Eigen::Index rows = 0;  ///< rows that differ in any column
};

class FlightComparison {
 public:
  /// `single`: its numbers are floats.
  FlightComparison(const FlightLog& log, bool single) : log_(log), single_(single) {}

  /// Whether `answer` equals the logged value in `row`, to the bit or to the printed digits. True without a logged
  /// value.
  bool same(const LoggedColumn& column, Eigen::Index row, double answer) const;

  /// The column that differs in `row`; null: none. `answers`: one column of them.
  const LoggedColumn* difference(Eigen::Index row, const Eigen::Ref<const Eigen::VectorXd>& answers) const;

  /// The first, in the rows' order; none: the same.
  std::optional<FlightDifference> first(const Eigen::MatrixXd& answers) const;

  /// Cells that agree to their digits alone: their numbers have other bits.
  Eigen::Index rounded(const Eigen::MatrixXd& answers) const;

  /// Numbers of the scalar between the two, and one.
  double units(double logged, double answer) const;

  /// Digits that tell each of its numbers from the others.
  int digits_needed() const { return single_ ? 9 : 17; }

 private:
  double exact(double value) const { return single_ ? static_cast<double>(static_cast<float>(value)) : value; }

  const FlightLog& log_;
  bool single_;
};

/// A number with all its digits.
std::string all_digits(double value, bool single);

}  // namespace nlo::trainer
