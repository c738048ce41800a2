// SPDX-License-Identifier: MIT
// A number of an expression as it is in an export: rounded once to the scalar in flight. Here it is used in double.
#pragma once

#include "codegen/model/expression_values.h"

namespace nlo::codegen {

template <class Scalar>
struct FlownNumber {
  double value = 0.0;

  FlownNumber() = default;
  explicit FlownNumber(double number) : value(static_cast<double>(static_cast<Scalar>(number))) {}
  static FlownNumber computed(double value) {
    FlownNumber result;
    result.value = value;
    return result;
  }

  friend FlownNumber operator+(FlownNumber a, FlownNumber b) { return computed(a.value + b.value); }
  friend FlownNumber operator-(FlownNumber a, FlownNumber b) { return computed(a.value - b.value); }
  friend FlownNumber operator*(FlownNumber a, FlownNumber b) { return computed(a.value * b.value); }
  friend FlownNumber operator/(FlownNumber a, FlownNumber b) { return computed(a.value / b.value); }
  friend FlownNumber value_of(Function function, FlownNumber x) {
    return computed(nlo::codegen::value_of(function, x.value));
  }
};

}  // namespace nlo::codegen
