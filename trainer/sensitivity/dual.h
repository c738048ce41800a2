// SPDX-License-Identifier: MIT
// A number and its derivative. Run through the runtime's own discretisation formulas it gives their derivative with
// respect to the eigenvalue, for every hold, without a second copy of them. The coefficients are analytic in lambda:
// seeding the real part gives the complex derivative. So it does through the known equations of a plant.
#pragma once

namespace nlo::trainer {

template <class Value>
struct DualOf {
  Value value, slope;

  constexpr DualOf() = default;
  constexpr DualOf(Value v, Value s = Value(0.0)) : value(v), slope(s) {}  // NOLINT(google-explicit-constructor)

  friend constexpr DualOf operator+(DualOf a, DualOf b) { return {a.value + b.value, a.slope + b.slope}; }
  friend constexpr DualOf operator-(DualOf a, DualOf b) { return {a.value - b.value, a.slope - b.slope}; }
  friend constexpr DualOf operator-(DualOf a) { return {-a.value, -a.slope}; }
  friend constexpr DualOf operator*(DualOf a, DualOf b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  friend constexpr DualOf operator/(DualOf a, DualOf b) {
    const Value ratio = a.value / b.value;
    return {ratio, (a.slope - ratio * b.slope) / b.value};
  }
  friend constexpr bool operator<(DualOf a, DualOf b) { return a.value < b.value; }
  friend constexpr bool operator>(DualOf a, DualOf b) { return a.value > b.value; }
};

using Dual = DualOf<double>;

}  // namespace nlo::trainer
