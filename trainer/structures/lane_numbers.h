// SPDX-License-Identifier: MIT
// A number of each of eight trajectories, to evaluate known equations side by side.
#pragma once

#include <algorithm>

#include "codegen/model/expression_values.h"
#include "trainer/gradients/sensitivity/linear_latent.h"

namespace nlo::trainer {

template <class Scalar>
struct Lanes {
  Scalar at[kGroup];

  Lanes() = default;
  Lanes(double value) { std::fill_n(at, kGroup, static_cast<Scalar>(value)); }  // NOLINT: a number is one of each
  explicit Lanes(const Scalar* from) { std::copy_n(from, kGroup, at); }

  template <class Operation>
  static Lanes each(const Lanes& a, const Lanes& b, const Operation& operation) {
    Lanes result;
    for (int l = 0; l < kGroup; ++l) result.at[l] = operation(a.at[l], b.at[l]);
    return result;
  }
  friend Lanes operator+(const Lanes& a, const Lanes& b) {
    return each(a, b, [](Scalar u, Scalar v) { return u + v; });
  }
  friend Lanes operator-(const Lanes& a, const Lanes& b) {
    return each(a, b, [](Scalar u, Scalar v) { return u - v; });
  }
  friend Lanes operator*(const Lanes& a, const Lanes& b) {
    return each(a, b, [](Scalar u, Scalar v) { return u * v; });
  }
  friend Lanes operator/(const Lanes& a, const Lanes& b) {
    return each(a, b, [](Scalar u, Scalar v) { return u / v; });
  }
  friend Lanes value_of(codegen::Function function, const Lanes& x) {
    return each(x, x, [function](Scalar v, Scalar) { return codegen::value_of(function, v); });
  }
  /// Slope of a function at x, where its value is known. 0 where abs or sign has none.
  friend Lanes slope_of(codegen::Function function, const Lanes& x, const Lanes& value) {
    using codegen::Function;
    const Lanes one(1.0);
    switch (function) {
      case Function::kSine:
        return value_of(Function::kCosine, x);
      case Function::kCosine:
        return Lanes(0.0) - value_of(Function::kSine, x);
      case Function::kTanh:
        return one - value * value;
      case Function::kExponential:
        return value;
      case Function::kLogarithm:
        return one / x;
      case Function::kRoot:
        return Lanes(0.5) / value;
      case Function::kArcTangent:
        return one / (one + x * x);
      case Function::kMagnitude:
        return value_of(Function::kSign, x);
      default:
        return Lanes(0.0);
    }
  }
  friend Lanes kept_within(Lanes x, double low, double high) {
    for (Scalar& value : x.at) value = std::clamp(value, static_cast<Scalar>(low), static_cast<Scalar>(high));
    return x;
  }
};

}  // namespace nlo::trainer
