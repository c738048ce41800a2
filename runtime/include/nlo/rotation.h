// SPDX-License-Identifier: MIT
// Rotations of vectors with three components, without libm and in a fixed number of operations.
//   dz/dt = -w x z over a step h, w on a ramp:   z+ = exp(-[theta]x) z,   theta = h (w_0 + w_1) / 2 + h^2/12 w_0 x w_1
// Exact if the direction of w is constant, otherwise of order four (Magnus expansion; its second term is the coning
// term).
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/latent.h"

namespace nlo::inline NLO_ISA {

/// A rotation R = exp(-[theta]x), stored as R - 1, so that small rotations keep their precision.
template <class T>
struct Rotation {
  T minus_1[3][3];

  /// Returns the rotation of theta [rad]. Computes the unit quaternion of theta / 2^kDoublings by its series and
  /// squares it kDoublings times. |theta| <= 2^kDoublings; error up to 2 kDoublings rounding units of theta.
  template <int kDoublings>
  static constexpr Rotation of(const T (&theta)[3]) {
    T scale = T(0.5);
    for (int i = 0; i < kDoublings; ++i) scale *= T(0.5);
    T v[3];  // the quaternion is [c, v]
    for (int i = 0; i < 3; ++i) v[i] = theta[i] * scale;
    const T square = square_of(v);
    constexpr int kTerms = 8;  // 0.5^16 / 17! is below the rounding of a double
    T sine = T(1), c = T(1);
    for (int k = kTerms; k >= 1; --k) {
      sine = T(1) - rounded<T>(rounded<T>(square * sine) * reciprocal<T>(2 * k * (2 * k + 1)));
      c = T(1) - rounded<T>(rounded<T>(square * c) * reciprocal<T>((2 * k - 1) * 2 * k));
    }
    for (int i = 0; i < 3; ++i) v[i] *= sine;
    for (int i = 0; i < kDoublings; ++i) {
      const T twice = T(2) * c;
      c = T(1) - T(2) * square_of(v);
      for (int j = 0; j < 3; ++j) v[j] *= twice;
    }
    Rotation r{};
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      r.minus_1[i][i] = T(-2) * (rounded<T>(v[j] * v[j]) + rounded<T>(v[k] * v[k]));
      const T product = rounded<T>(v[i] * v[j]), turn = rounded<T>(c * v[k]);
      r.minus_1[i][j] = T(2) * (product + turn);
      r.minus_1[j][i] = T(2) * (product - turn);
    }
    return r;
  }

  /// v <- R v.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  NLO_INLINE constexpr void turn(T (&v)[3]) const {
    T change[3];
    for (int i = 0; i < 3; ++i) {
      change[i] = rounded<T>(minus_1[i][0] * v[0]);
      change[i] = multiply_add<kArithmetic>(minus_1[i][1], v[1], change[i]);
      change[i] = multiply_add<kArithmetic>(minus_1[i][2], v[2], change[i]);
    }
    for (int i = 0; i < 3; ++i) v[i] += change[i];
  }

 private:
  static constexpr T square_of(const T (&v)[3]) {
    return rounded<T>(v[0] * v[0]) + rounded<T>(v[1] * v[1]) + rounded<T>(v[2] * v[2]);
  }
};

/// Computes theta [rad] of a step of h [s] during which w [rad/s] changes linearly from w_0 to w_1.
template <class T>
constexpr void rotation_vector(const T (&w_0)[3], const T (&w_1)[3], T h, T (&theta)[3]) {
  const T half = T(0.5) * h, twelfth = rounded<T>(rounded<T>(h * h) * T(1.0 / 12));
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const T cross = rounded<T>(w_0[j] * w_1[k]) - rounded<T>(w_0[k] * w_1[j]);
    theta[i] = rounded<T>(half * (w_0[i] + w_1[i])) + rounded<T>(twelfth * cross);
  }
}

/// v <- v / |v|, or 0 if v is 0. v: finite, of any size. The length of the result is 1 to 3 rounding units.
template <Arithmetic kArithmetic = Arithmetic::kFast, class T>
constexpr void make_unit(T (&v)[3]) {
  T largest = T(0);
  for (const T value : v) {
    const T size = select<kArithmetic>(value < T(0), -value, value);
    largest = select<kArithmetic>(size > largest, size, largest);
  }
  const T divisor = select<kArithmetic>(largest > T(0), largest, T(1));
  T square = T(0);  // 1 to 3
  for (T& value : v) {
    value /= divisor;
    square += rounded<T>(value * value);
  }
  // Newton's method for 1 / sqrt(square). It starts at a linear fit, within 8 %.
  T inverse = T(1.17) - rounded<T>(T(0.205) * square);
  for (int i = 0; i < 4; ++i) {
    const T error = rounded<T>(rounded<T>(square * inverse) * inverse);
    inverse *= T(1.5) - T(0.5) * error;
  }
  for (T& value : v) value *= inverse;
}

}  // namespace nlo::inline NLO_ISA
