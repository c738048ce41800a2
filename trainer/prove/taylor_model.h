// SPDX-License-Identifier: MIT
// Functions over a box as polynomials with a bound of the remainder (Makino and Berz 1998):
//   f(x) = sum over products of c t^power +- remainder,   t = (x - centre) / radius in [-1, 1]^n
// Polynomials keep the cancellation of terms, which interval arithmetic loses. Rounding is in the remainder.
#pragma once

#include <array>
#include <cstddef>

#include "codegen/model/expression_values.h"

namespace nlo::trainer {

class TaylorModel {
 public:
  static constexpr std::size_t kVariables = 3;
  static constexpr int kOrder = 6;  ///< largest total degree of the products
  using Powers = std::array<int, kVariables>;

  TaylorModel(double value = 0.0) { coefficients_[0] = value; }  // NOLINT: a number is a constant function
  /// Returns x for one variable.
  static TaylorModel variable(std::size_t index, double centre, double radius);

  /// Adds c t^power. Above the degree kOrder, |c| is added to the remainder instead.
  void add(const Powers& power, double c);
  void widen(double by) { remainder_ += by; }

  /// Returns a bound of |f|.
  double most() const;

  friend TaylorModel operator+(const TaylorModel& a, const TaylorModel& b);
  friend TaylorModel operator-(const TaylorModel& a, const TaylorModel& b);
  friend TaylorModel operator*(const TaylorModel& a, const TaylorModel& b);
  /// The remainder is infinite if b may be 0. The remainder of value_of() is infinite if the function may have no
  /// value.
  friend TaylorModel operator/(const TaylorModel& a, const TaylorModel& b);
  friend TaylorModel value_of(codegen::Function function, const TaylorModel& x);
  friend TaylorModel minimum_of(const TaylorModel& a, const TaylorModel& b);
  friend TaylorModel maximum_of(const TaylorModel& a, const TaylorModel& b);

 private:
  static constexpr std::size_t kProducts = 84;  ///< (3 + 6)! / (3! 6!)
  using Series = std::array<codegen::Interval, kOrder + 2>;

  double size() const;  ///< sum of |c|
  /// Returns g(x) from the Taylor series of g around the value at the centre. The last term uses the series around all
  /// numbers of the range of x (Lagrange's remainder).
  template <class SeriesOf>
  TaylorModel composed(const SeriesOf& series_of) const;

  std::array<double, kProducts> coefficients_{};
  double remainder_ = 0.0;
};

}  // namespace nlo::trainer
