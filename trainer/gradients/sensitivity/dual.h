// SPDX-License-Identifier: MIT
// A number and its derivative. If the discretisation formulas of the runtime are evaluated with dual numbers, they also
// give their derivative with respect to the eigenvalue, for every hold and without a second copy of the formulas. The
// coefficients are analytic in lambda, so seeding the real part gives the complex derivative.
#pragma once

namespace nlo::trainer {

struct Dual {
  double value = 0.0, slope = 0.0;

  constexpr Dual() = default;
  constexpr Dual(double v, double s = 0.0) : value(v), slope(s) {}  // NOLINT(google-explicit-constructor)

  friend constexpr Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.slope + b.slope}; }
  friend constexpr Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.slope - b.slope}; }
  friend constexpr Dual operator-(Dual a) { return {-a.value, -a.slope}; }
  friend constexpr Dual operator*(Dual a, Dual b) { return {a.value * b.value, a.slope * b.value + a.value * b.slope}; }
  friend constexpr Dual operator/(Dual a, Dual b) {
    const double ratio = a.value / b.value;
    return {ratio, (a.slope - ratio * b.slope) / b.value};
  }
  friend constexpr bool operator<(Dual a, Dual b) { return a.value < b.value; }
  friend constexpr bool operator>(Dual a, Dual b) { return a.value > b.value; }
};

}  // namespace nlo::trainer
