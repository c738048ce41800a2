// SPDX-License-Identifier: MIT
// Activations and their slopes, for scalars and for SIMD packs alike: the trainer differentiates the very function
// that flies. No libm.
#pragma once

#include <cstdint>

#include "nlo/arithmetic.h"
#include "nlo/simd.h"

namespace nlo {

enum class Activation : std::uint8_t { kTanh, kRelu, kSilu };

/// Largest |tanh_rational(x) - tanh(x)| over every float32 x, infinities included (measured 4.2e-7).
inline constexpr double kTanhMaxError = 5e-7;

/// tanh(x) ~ x P(x^2) / Q(x^2), degrees 9/8, x clamped to +-7.75.
/// Minimax fit of the absolute error on [0, 7.75] (4.1e-9; 3.7e-8 as its coefficients are rounded; 4.2e-7 in float32).
/// The leading coefficient is exactly 1, so small x pass unchanged, and |result| <= 1. Not a number gives about 1.
template <Arithmetic kArithmetic = Arithmetic::kFast, class T>
NLO_INLINE constexpr T tanh_rational(T x) {
  // consteval: without optimisation too, no double reaches a target that would have to emulate it.
  constexpr auto c = [](double value) consteval {
    return simd::literal<T>(value);
  };
  constexpr auto horner = [](T polynomial, T s, auto next) {
    return multiply_add<kArithmetic, T>(polynomial, s, T{} + next);
  };
  const T limit = T{} + c(7.75);
  x = simd::max(simd::min(x, limit), -limit);
  const T s = x * x;
  T p = T{} + c(1.55599142e-08);
  p = horner(p, s, c(2.20985712e-05));
  p = horner(p, s, c(0.00358292833));
  p = horner(p, s, c(0.134537607));
  p = horner(p, s, c(1.0));
  T q = T{} + c(8.646428e-07);
  q = horner(q, s, c(0.000343050633));
  q = horner(q, s, c(0.0262066592));
  q = horner(q, s, c(0.467870831));
  q = horner(q, s, c(1.0));
  return x * p / q;
}

/// a = activation(v).
template <Activation kKind, Arithmetic kArithmetic = Arithmetic::kFast, class T>
NLO_INLINE constexpr T activate(T v) {
  const T zero{};
  if constexpr (kKind == Activation::kTanh) {
    return tanh_rational<kArithmetic>(v);
  } else if constexpr (kKind == Activation::kRelu) {
    return simd::max(v, zero);
  } else {  // silu: v sigmoid(v), with sigmoid(v) = (1 + tanh(v / 2)) / 2
    constexpr auto kHalf = simd::literal<T>(0.5);
    const T half = v * kHalf;
    return multiply_add<kArithmetic, T>(half, tanh_rational<kArithmetic>(half), half);
  }
}

/// da/dv, from the pre-activation v and the result a.
template <Activation kKind, class T>
NLO_INLINE constexpr T activation_slope(T v, T a) {
  const T zero{};
  const T one = zero + simd::literal<T>(1.0);
  if constexpr (kKind == Activation::kTanh) {
    return one - a * a;
  } else if constexpr (kKind == Activation::kRelu) {
    return v > zero ? one : zero;
  } else {  // s + v s (1 - s), s = sigmoid(v)
    const auto half = simd::literal<T>(0.5);
    const T s = half + half * tanh_rational(v * half);
    return s + a * (one - s);
  }
}

}  // namespace nlo
