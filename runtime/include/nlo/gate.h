// SPDX-License-Identifier: MIT
// The gates of a gated observer (gated_observer.h), by the tanh of activation.h:
//   sigmoid(2 a) = (1 + tanh a) / 2                       a reset; how much of the way to the target over one period
//   1 - exp(-periods softplus(2 a))                       the same over any number of periods
// The second is the first where periods = 1: exp(-softplus(v)) = 1 - sigmoid(v).
#pragma once

#include "nlo/activation.h"
#include "nlo/arithmetic.h"
#include "nlo/latent.h"

namespace nlo {

/// (1 + t) / 2 of t = tanh(a). T is a scalar or a vector.
template <Arithmetic kArithmetic = Arithmetic::kFast, class T>
constexpr T gate_of(T t) {
  constexpr auto kHalf = simd::literal<T>(0.5);
  return multiply_add<kArithmetic, T>(t, T{} + kHalf, T{} + kHalf);
}

/// log(1 + t) for 0 <= t <= 1, relative error below 4 rounding units: 2 atanh(t / (2 + t)), whose series in
/// (t / (2 + t))^2 <= 1/9 has dropped below the rounding of a double after 16 terms.
template <class T>
constexpr T log_1_plus(T t) {
  constexpr int kTerms = 16;
  const T w = t / (T(2) + t), square = w * w;
  T series = reciprocal<T>(2 * kTerms + 1);
  for (int k = kTerms - 1; k >= 0; --k) series = rounded<T>(square * series) + reciprocal<T>(2 * k + 1);
  return rounded<T>(T(2) * w * series);
}

/// 1 - exp(-periods softplus(2 a)): what a unit goes of its way to the target over so many sample periods. In [0, 1],
/// absolute error below 4 rounding units, times the periods where these are more than one. `a` finite, periods > 0.
template <class T>
constexpr T gate_over(T a, T periods) {
  const T v = T(2) * a;
  const T decay = decay_minus_1(v < T(0) ? -v : v) + T(1);
  const T softplus = (v > T(0) ? v : T(0)) + log_1_plus(decay);
  return -decay_minus_1(rounded<T>(periods * softplus));
}

}  // namespace nlo
