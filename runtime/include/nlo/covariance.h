// SPDX-License-Identifier: MIT
// Measurement update of an extended Kalman filter, one output after another, for the state x and its covariance P
// (prior_observer.h):
//   S = h' P h (1 + 2^-16) + r,  K = P h / S,  x <- x + K (nu - h' (x - x-)),  P <- P - K (P h)'
// P is symmetric; its upper triangle is stored row by row. The term 2^-16 acts as additional noise: without it, a very
// exact measurement would leave a variance that is only rounding error in float and might be negative.
#pragma once

#include "nlo/functions.h"
#include "nlo/kernels/arithmetic.h"

namespace nlo::inline NLO_ISA {

inline constexpr float kLeastNoise = 0x1p-16F;  ///< least noise of an output, as a share of h' P h

constexpr int triangle_size(int n) {
  return n * (n + 1) / 2;
}

/// Returns the index of element (i, j) of a symmetric n x n matrix in its stored upper triangle.
constexpr int in_triangle(int n, int i, int j) {
  const int low = i < j ? i : j, high = i < j ? j : i;
  return low * n - low * (low - 1) / 2 + high - low;
}

/// Returns exp(c) with c limited to [-16, 16]; NaN for NaN.
template <Arithmetic kArithmetic, class Scalar>
NLO_INLINE Scalar noise_of(Scalar c) {
  constexpr Scalar kFarthest = Scalar(16);
  const Scalar below = select<kArithmetic>(!(c > kFarthest), c, kFarthest);
  return exponential(select<kArithmetic>(!(below < -kFarthest), below, -kFarthest));
}

/// Corrects x and P by one output.
///   slopes  h, n: derivatives of the output with respect to the states, at x-
///   nu      innovation of the output, y - h(x-)
///   noise   r > 0, variance of the output
///   arrived false: the output was not measured, and K = 0
///   change  n: x - x- so far; the correction is added
///   p       upper triangle of P; updated
template <Arithmetic kArithmetic, int n, class Scalar>
NLO_INLINE void take_output(const Scalar* slopes, Scalar nu, Scalar noise, bool arrived, Scalar (&change)[n],
                            Scalar* p) {
  // Both loops over P read its triangle in the stored order, because computing the index of an element takes longer
  // than its product. Each sum of P h adds its terms in the order of the columns.
  Scalar ph[n]{}, spread = Scalar(0), rest = nu;
  const Scalar* stored = p;
  for (int i = 0; i < n; ++i) {
    ph[i] = multiply_add<kArithmetic>(*stored++, slopes[i], ph[i]);
    for (int j = i + 1; j < n; ++j) {
      const Scalar element = *stored++;
      ph[i] = multiply_add<kArithmetic>(element, slopes[j], ph[i]);
      ph[j] = multiply_add<kArithmetic>(element, slopes[i], ph[j]);
    }
  }
  for (int i = 0; i < n; ++i) {
    spread = multiply_add<kArithmetic>(slopes[i], ph[i], spread);
    rest = multiply_add<kArithmetic>(-slopes[i], change[i], rest);
  }
  // A negative value is rounding error. NaN stays NaN.
  spread = select<kArithmetic>(!(spread < Scalar(0)), spread, Scalar(0));
  const Scalar inverse = Scalar(1) / (multiply_add<kArithmetic>(Scalar(1) + Scalar(kLeastNoise), spread, noise));
  const Scalar share = select<kArithmetic>(arrived, inverse, Scalar(0));
  for (int i = 0; i < n; ++i) {
    const Scalar gain = rounded<Scalar>(ph[i] * share);
    change[i] = multiply_add<kArithmetic>(gain, rest, change[i]);
    for (int j = i; j < n; ++j, ++p) *p = multiply_add<kArithmetic>(-gain, ph[j], *p);
  }
}

}  // namespace nlo::inline NLO_ISA
