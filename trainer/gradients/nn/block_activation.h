// SPDX-License-Identifier: MIT
// Activations over SIMD registers for training: a = s(v), s'(v) and s''(v). In float they are the functions of the
// runtime. Each row of codegen/model/activations.h that can be trained has a specialisation; a row without one does not
// compile here.
#pragma once

#include <cmath>
#include <type_traits>

#include "nlo/jvp.h"
#include "nlo/kernels/activation.h"
#include "nlo/kernels/simd.h"

namespace nlo::trainer {

/// tanh. In float it is the runtime's approximation. In double it is exact: gradients are compared with finite
/// differences there, and the slope 1 - a^2 belongs to tanh and not to its approximation.
template <class P>
NLO_INLINE P smooth_tanh(P v) {
  using Scalar = typename simd::ScalarOf<P>::Type;
  if constexpr (std::is_same_v<P, double>) {
    return std::tanh(v);
  } else if constexpr (std::is_same_v<Scalar, double>) {
    constexpr int kN = sizeof(P) / sizeof(double);
    for (int i = 0; i < kN; ++i) v[i] = std::tanh(v[i]);
    return v;
  } else {
    return tanh_rational(v);
  }
}

template <class P>
NLO_INLINE P smooth_sigmoid(P v) {
  const P half = P{} + simd::literal<P>(0.5);
  return half + half * smooth_tanh(v * half);
}

/// P is a scalar or a register of them. Slope and curvature get v and a = value(v). If the row of
/// codegen/model/activations.h says that the slope does not need v, they get a in its place.
template <Activation kKind>
struct BlockActivation;

template <>
struct BlockActivation<Activation::kTanh> {
  template <class P>
  static NLO_INLINE P value(P v) {
    return smooth_tanh(v);
  }
  template <class P>
  static NLO_INLINE P slope(P v, P a) {
    return activation_slope<Activation::kTanh>(v, a);
  }
  template <class P>
  static NLO_INLINE P curvature(P, P a) {
    const P one = P{} + simd::literal<P>(1.0);
    return -simd::literal<P>(2.0) * a * (one - a * a);
  }
};

template <>
struct BlockActivation<Activation::kRelu> {
  template <class P>
  static NLO_INLINE P value(P v) {
    return activate<Activation::kRelu>(v);
  }
  template <class P>
  static NLO_INLINE P slope(P v, P a) {
    return activation_slope<Activation::kRelu>(v, a);
  }
  template <class P>
  static NLO_INLINE P curvature(P, P) {
    return P{};
  }
};

template <>
struct BlockActivation<Activation::kSilu> {
  template <class P>
  static NLO_INLINE P value(P v) {
    const P half = v * simd::literal<P>(0.5);
    return half + half * smooth_tanh(half);
  }
  template <class P>
  static NLO_INLINE P slope(P v, P a) {
    const P s = smooth_sigmoid(v);
    return s + a * (P{} + simd::literal<P>(1.0) - s);
  }
  /// Returns s (1 - s) (2 + v (1 - 2 s)), s = sigmoid(v).
  template <class P>
  static NLO_INLINE P curvature(P v, P) {
    const P one = P{} + simd::literal<P>(1.0);
    const auto two = simd::literal<P>(2.0);
    const P s = smooth_sigmoid(v);
    return s * (one - s) * (P{} + two + v * (one - two * s));
  }
};

}  // namespace nlo::trainer
