// SPDX-License-Identifier: MIT
// Mathematical functions for the known equations of a plant (prior_observer.h), without libm and without a branch on
// data. Each operation is rounded by itself, so that the bits are the same on every target and in C99. Outside of its
// range a function returns NaN; the step that meets the NaN reports it.
#pragma once

#include <bit>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "nlo/gate.h"
#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// Coefficients of the series of sin and cos for |x| <= pi / 4, and pi / 2 as a sum of three parts. The first two parts
/// have so few digits that their products with integers up to 2^13 are exact (Cody and Waite).
template <class T>
struct CircleFit {
  static constexpr bool kSingle = sizeof(T) == 4;
  static constexpr int kTerms = kSingle ? 5 : 8;
  static constexpr T kFarthest = T(8192);  ///< largest |x|; beyond it neighbouring floats are 0.001 rad apart
  T quarter[3] = {T(kSingle ? 1.5703125 : 1.57079632673412561417),
                  T(kSingle ? 4.8351287841796875e-4 : 6.07710050630396597660e-11),
                  T(kSingle ? 3.139164786504813e-7 : 2.02226624879595063154e-21)};
  T sine[kTerms], cosine[kTerms];  ///< -1/3!, 1/5!, ... and -1/2!, 1/4!, ...

  constexpr CircleFit() : sine{}, cosine{} {
    double factorial = 1.0;
    for (int k = 0; k < kTerms; ++k) {
      factorial *= -(2 * k + 1) * (2 * k + 2);
      cosine[k] = static_cast<T>(1.0 / factorial);
      sine[k] = static_cast<T>(1.0 / (factorial * (2 * k + 3)));
    }
  }
};

template <class T>
struct SineAndCosine {
  T sine, cosine;
};

/// Returns sin(x) and cos(x) for |x| < 8192, else NaN. Absolute error below 2e-7 in float, 3e-16 in double.
template <class T>
constexpr SineAndCosine<T> circle(T x) {
  constexpr Arithmetic kEach = Arithmetic::kDeterministic;
  constexpr CircleFit<T> kFit;
  const bool known = is_below(x, CircleFit<T>::kFarthest);
  T r = select<kEach>(known, rounded<T>(x), T(0));
  const T quarters = rounded<T>(r * T(0.63661977236758134308)), half = select<kEach>(r < T(0), T(-0.5), T(0.5));
  const auto n = static_cast<std::int32_t>(quarters + half);
  for (const T part : kFit.quarter) r -= rounded<T>(static_cast<T>(n) * part);
  const T z = rounded<T>(r * r);
  const T sine = r + rounded<T>(rounded<T>(r * z) * horner<kEach>(z, kFit.sine));
  const T cosine = T(1) + rounded<T>(z * horner<kEach>(z, kFit.cosine));
  const auto in_quadrant = [&](std::uint32_t quadrant) {
    const T value = select<kEach>((quadrant & 1U) == 0, sine, cosine);
    return select<kEach>(known, select<kEach>((quadrant & 2U) == 0, value, -value),
                         std::numeric_limits<T>::quiet_NaN());
  };
  return {in_quadrant(static_cast<std::uint32_t>(n)), in_quadrant(static_cast<std::uint32_t>(n) + 1U)};
}
template <class T>
constexpr T sine(T x) {
  return circle(x).sine;
}
template <class T>
constexpr T cosine(T x) {
  return circle(x).cosine;
}

/// Returns tanh(x) with the bits of a tanh activation; 1 for NaN.
template <class T>
constexpr T hyperbolic_tangent(T x) {
  return tanh_rational<Activation::kTanh, Arithmetic::kDeterministic>(rounded<T>(x));
}

/// Returns exp(x) for |x| < 80, 0 for x <= -80, NaN for x >= 80. Relative error below 3 rounding units.
template <class T>
constexpr T exponential(T x) {
  constexpr Arithmetic kEach = Arithmetic::kDeterministic;
  using Bits = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
  constexpr T kFarthest = T(80);
  const bool known = is_below(x, kFarthest);
  T r = select<kEach>(known, rounded<T>(x), T(0));
  const T doublings = rounded<T>(r * T(1.44269504088896340736)), half = select<kEach>(r < T(0), T(-0.5), T(0.5));
  const auto n = static_cast<std::int32_t>(doublings + half);
  // log(2) as a sum of two parts. The first has so few digits that its products with integers up to 116 are exact.
  r = (r - rounded<T>(static_cast<T>(n) * T(0.693145751953125))) -
      rounded<T>(static_cast<T>(n) * T(1.42860682030941723212e-6));
  T series = T(1);
  for (int k = sizeof(T) == 4 ? 7 : 13; k >= 1; --k)
    series = T(1) + rounded<T>(rounded<T>(r * series) * reciprocal<T>(k));
  const Bits power = (Bits{n} << (std::numeric_limits<T>::digits - 1)) + std::bit_cast<Bits>(T(1));
  const T beyond = select<kEach>(x <= -kFarthest, T(0), std::numeric_limits<T>::quiet_NaN());
  return select<kEach>(known, series * std::bit_cast<T>(power), beyond);
}

/// Returns sqrt(x) for a normal x, 0 for smaller x >= 0, else NaN. Relative error below 2 rounding units.
template <class T>
constexpr T square_root(T x) {
  constexpr Arithmetic kEach = Arithmetic::kDeterministic;
  using Bits = std::conditional_t<sizeof(T) == 4, std::uint32_t, std::uint64_t>;
  const bool known = x >= (std::numeric_limits<T>::min)() && x <= (std::numeric_limits<T>::max)();
  const T v = select<kEach>(known, rounded<T>(x), T(1)), half = T(0.5) * v;
  constexpr Bits kLine = sizeof(T) == 4 ? Bits{0x5f3759dfU} : static_cast<Bits>(0x5fe6eb50c7b537a9U);
  // Newton's method for 1 / sqrt(v). It starts within 4 %, at a linear fit of the logarithm.
  T inverse = std::bit_cast<T>(static_cast<Bits>(kLine - (std::bit_cast<Bits>(v) >> 1U)));
  for (int i = 0; i < (sizeof(T) == 4 ? 3 : 4); ++i)
    inverse *= T(1.5) - rounded<T>(rounded<T>(half * inverse) * inverse);
  const T root = rounded<T>(v * inverse);
  const T value = root + rounded<T>(rounded<T>(T(0.5) * inverse) * (v - rounded<T>(root * root)));
  const bool none = x >= T(0) && x < (std::numeric_limits<T>::min)();
  return select<kEach>(known, value, select<kEach>(none, T(0), std::numeric_limits<T>::quiet_NaN()));
}

/// Returns |x|.
template <class T>
constexpr T magnitude(T x) {
  return select<Arithmetic::kDeterministic>(x < T(0), -x, x);
}

/// Returns the sign of x: -1, 0 or 1.
template <class T>
constexpr T sign_of(T x) {
  const T above = select<Arithmetic::kDeterministic>(x > T(0), T(1), T(0) * x);
  return select<Arithmetic::kDeterministic>(x < T(0), T(-1), above);
}

/// Returns the lesser of a and b; NaN if either is NaN.
template <class T>
constexpr T minimum(T a, T b) {
  return select<Arithmetic::kDeterministic>(a > b || b != b, b, a);
}

/// Returns the greater of a and b; NaN if either is NaN.
template <class T>
constexpr T maximum(T a, T b) {
  return select<Arithmetic::kDeterministic>(a < b || b != b, b, a);
}

/// Returns atan(x) for any x. Absolute error below 2e-7 in float, 4e-16 in double.
template <class T>
constexpr T arc_tangent(T x) {
  constexpr Arithmetic kEach = Arithmetic::kDeterministic;
  const T size = magnitude(rounded<T>(x));
  // The argument of the series is at most tan(pi / 8). Larger ones are reduced by atan(v) = pi/2 + atan(-1/v) and
  // atan(v) = pi/4 + atan((v-1)/(v+1)).
  const bool steep = size > T(2.4142135623730950488), middle = size > T(0.41421356237309504880);
  const T above = select<kEach>(steep, T(-1), size - T(1)), below = select<kEach>(steep, size, size + T(1));
  const T v = select<kEach>(middle, above, size) / select<kEach>(middle, below, T(1));
  const T from = select<kEach>(steep, T(1.57079632679489661923), T(0.78539816339744830962));
  const T z = rounded<T>(v * v);
  constexpr int kTerms = sizeof(T) == 4 ? 9 : 20;
  T series = reciprocal<T>(2 * kTerms + 1);
  for (int k = kTerms - 1; k >= 0; --k) series = reciprocal<T>(2 * k + 1) - rounded<T>(z * series);
  const T value = select<kEach>(middle, from, T(0)) + rounded<T>(v * series);
  return select<kEach>(x < T(0), -value, value);
}

/// Returns log(x) for a normal x > 0, else NaN. Absolute error below 2 rounding units of max(1, |log(x)|).
template <class T>
constexpr T logarithm(T x) {
  constexpr Arithmetic kEach = Arithmetic::kDeterministic;
  using Bits = std::conditional_t<sizeof(T) == 4, std::int32_t, std::int64_t>;
  const bool known = x >= (std::numeric_limits<T>::min)() && x <= (std::numeric_limits<T>::max)();
  constexpr int kFraction = std::numeric_limits<T>::digits - 1;
  constexpr Bits kRoot = std::bit_cast<Bits>(T(0.70710678118654752440)), kOne = std::bit_cast<Bits>(T(1));
  // x = 2^n m, m between sqrt(1/2) and sqrt(2).
  const Bits above = std::bit_cast<Bits>(select<kEach>(known, rounded<T>(x), T(1))) - kRoot;
  const Bits n = above >> kFraction;
  const T m = std::bit_cast<T>(static_cast<Bits>(above - (n << kFraction) + kRoot));
  static_assert(kOne > kRoot);
  const T value = rounded<T>(static_cast<T>(n) * T(0.69314718055994530942)) + log_1_plus(m - T(1));
  return select<kEach>(known, value, std::numeric_limits<T>::quiet_NaN());
}

}  // namespace nlo::inline NLO_ISA
