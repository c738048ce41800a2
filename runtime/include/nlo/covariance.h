// SPDX-License-Identifier: MIT
// The covariance P of a state that known equations step (prior_observer.h), and what a measurement does to it: the
// update of an extended Kalman filter, output by output.
//   S = h' P h (1 + 2^-16) + r,  K = P h / S,  x <- x + K (nu - h' (x - x-)),  P <- P - K (P h)'
// P is symmetric: the upper triangle is kept, row by row. The 2^-16 is noise, too: in float, what is left of a variance
// after a far more exact measurement would be rounding, and might be below 0.
#pragma once

#include "nlo/functions.h"
#include "nlo/kernels/arithmetic.h"

namespace nlo {

inline constexpr float kLeastNoise = 0x1p-16F;  ///< of an output: this part of the variance that P gives it

constexpr int triangle_size(int n) {
  return n * (n + 1) / 2;
}

/// Place of element (i, j) of a symmetric n x n matrix in its upper triangle.
constexpr int in_triangle(int n, int i, int j) {
  const int low = i < j ? i : j, high = i < j ? j : i;
  return low * n - low * (low - 1) / 2 + high - low;
}

/// exp(c), c kept within [-16, 16]; NaN stays what it is.
template <Arithmetic kArithmetic, class Scalar>
NLO_INLINE Scalar noise_of(Scalar c) {
  constexpr Scalar kFarthest = Scalar(16);
  const Scalar below = select<kArithmetic>(!(c > kFarthest), c, kFarthest);
  return exponential(select<kArithmetic>(!(below < -kFarthest), below, -kFarthest));
}

/// Takes one output, whose innovation is nu: adds to `change` (n), x - x- so far, and changes p, the triangle of P.
///   slopes  n, h: of the output by the states, at x-
///   noise   r > 0
template <Arithmetic kArithmetic, int n, class Scalar>
NLO_INLINE void take_output(const Scalar* slopes, Scalar nu, Scalar noise, Scalar (&change)[n], Scalar* p) {
  Scalar ph[n], spread = Scalar(0), rest = nu;
  for (int i = 0; i < n; ++i) {
    Scalar sum = Scalar(0);
    for (int j = 0; j < n; ++j) sum = multiply_add<kArithmetic>(p[in_triangle(n, i, j)], slopes[j], sum);
    ph[i] = sum;
  }
  for (int i = 0; i < n; ++i) {
    spread = multiply_add<kArithmetic>(slopes[i], ph[i], spread);
    rest = multiply_add<kArithmetic>(-slopes[i], change[i], rest);
  }
  // Below 0 is rounding. NaN stays what it is.
  spread = select<kArithmetic>(!(spread < Scalar(0)), spread, Scalar(0));
  const Scalar share = Scalar(1) / (multiply_add<kArithmetic>(Scalar(1) + Scalar(kLeastNoise), spread, noise));
  for (int i = 0; i < n; ++i) {
    const Scalar gain = rounded<Scalar>(ph[i] * share);
    change[i] = multiply_add<kArithmetic>(gain, rest, change[i]);
    for (int j = i; j < n; ++j) {
      Scalar& element = p[in_triangle(n, i, j)];
      element = multiply_add<kArithmetic>(-gain, ph[j], element);
    }
  }
}

}  // namespace nlo
