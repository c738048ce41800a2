// SPDX-License-Identifier: MIT
#include "trainer/app/replay/compare_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

namespace nlo::trainer {
namespace {

using Eigen::Index;

/// Returns the distance of a and b in steps from one representable value to the next.
template <class Whole, class Scalar>
double units_between(Scalar a, Scalar b) {
  constexpr Whole kSign = Whole(1) << (8 * sizeof(Whole) - 1);
  const Whole first = std::bit_cast<Whole>(a) & ~kSign, second = std::bit_cast<Whole>(b) & ~kSign;
  if (std::signbit(a) != std::signbit(b)) return static_cast<double>(first) + static_cast<double>(second);
  return static_cast<double>(std::max(first, second) - std::min(first, second));
}

}  // namespace

bool FlightComparison::same(const LoggedColumn& column, Index row, double answer) const {
  const double logged = column.values[row];
  if (std::isnan(logged) || exact(logged) == answer) return true;
  constexpr double kOfDoubles = 1.0 + 1e-9;  // allowance for the rounding of doubles
  return std::abs(logged - answer) <= kOfDoubles * column.half_digit[row];
}

const LoggedColumn* FlightComparison::difference(Index row, const Eigen::Ref<const Eigen::VectorXd>& answers) const {
  for (const LoggedColumn& column : log_.answers)
    if (!same(column, row, answers[column.answer])) return &column;
  return nullptr;
}

std::optional<FlightDifference> FlightComparison::first(const Eigen::MatrixXd& answers) const {
  std::optional<FlightDifference> found;
  for (Index row = 0; row < answers.cols(); ++row) {
    const LoggedColumn* column = difference(row, answers.col(row));
    if (column == nullptr) continue;
    if (!found) found = FlightDifference{row, column, 0};
    ++found->rows;
  }
  return found;
}

Index FlightComparison::rounded(const Eigen::MatrixXd& answers) const {
  Index count = 0;
  for (const LoggedColumn& column : log_.answers)
    for (Index row = 0; row < answers.cols(); ++row) {
      const double answer = answers(column.answer, row);
      count += !std::isnan(column.values[row]) && exact(column.values[row]) != answer && same(column, row, answer);
    }
  return count;
}

double FlightComparison::units(double logged, double answer) const {
  return single_ ? units_between<std::uint32_t>(static_cast<float>(logged), static_cast<float>(answer))
                 : units_between<std::uint64_t>(logged, answer);
}

std::string all_digits(double value, bool single) {
  return single ? fmt::format("{:.9g}", value) : fmt::format("{:.17g}", value);
}

}  // namespace nlo::trainer
