// SPDX-License-Identifier: MIT
// One number of each of eight trajectories in a SIMD vector, to evaluate known equations side by side.
#pragma once

#include <algorithm>
#include <cmath>

#include "codegen/model/expression_values.h"
#include "nlo/kernels/simd.h"
#include "trainer/gradients/sensitivity/linear_latent.h"

namespace nlo::trainer {

template <class Scalar>
using Lanes = simd::Pack<Scalar, kGroup>;

/// Returns the same number in all lanes.
template <class L>
NLO_INLINE L in_lanes(double value) {
  return simd::broadcast<L>(simd::literal<L>(value));
}

template <class L>
NLO_INLINE L kept_within(L x, double low, double high) {
  const L from = in_lanes<L>(low), to = in_lanes<L>(high), raised = x < from ? from : x;
  return raised > to ? to : raised;
}

template <class L>
NLO_INLINE L magnitude_of(L x) {
  return x < L{} ? -x : x;
}

/// Returns operation(x) lane by lane.
template <class L, class Operation>
L by_lane(L x, const Operation& operation) {
  for (int l = 0; l < kGroup; ++l) x[l] = operation(x[l]);
  return x;
}

template <class L>
L exponential_of(L x) {
  return by_lane(x, [](auto v) { return std::exp(v); });
}

template <class L>
L value_of_lanes(codegen::Function function, L x) {
  return by_lane(x, [function](auto v) { return codegen::value_of(function, v); });
}

/// Returns the slope of a function at x, where its value is known. Returns 0 where abs, sign or sqrt has none.
template <class L>
L slope_of_lanes(codegen::Function function, L x, L value) {
  using codegen::Function;
  const L one = in_lanes<L>(1.0);
  switch (function) {
    case Function::kSine:
      return value_of_lanes(Function::kCosine, x);
    case Function::kCosine:
      return -value_of_lanes(Function::kSine, x);
    case Function::kTanh:
      return one - value * value;
    case Function::kExponential:
      return value;
    case Function::kLogarithm:
      return one / x;
    case Function::kRoot:
      return value > L{} ? in_lanes<L>(0.5) / value : L{};
    case Function::kArcTangent:
      return one / (one + x * x);
    case Function::kMagnitude:
      return value_of_lanes(Function::kSign, x);
    default:
      return L{};
  }
}

}  // namespace nlo::trainer
