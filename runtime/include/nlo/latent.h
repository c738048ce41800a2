// SPDX-License-Identifier: MIT
// The latent system of a KKL observer in discrete time. From dz/dt = D z + F y (3) follows
//   z+ = z + (A - I) z + B0 y_k + B1 y_{k+1}
// D is block diagonal: each mode is a real eigenvalue or a complex pair, and therefore one real or complex scalar
// recurrence. The zero-order hold, the first-order hold and the paper's RK4 differ only in the coefficients.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"

namespace nlo {

/// Course of y between two samples.
enum class Hold : std::uint8_t {
  kZeroOrder,   ///< constant; exact
  kFirstOrder,  ///< a ramp; exact. The default: on Van der Pol at 50 Hz its error in z is 0.02 smaller
  kRk4,         ///< a ramp, stepped by the classical Runge-Kutta method; stable only for |lambda h| < 2.78
};

}  // namespace nlo

namespace nlo::inline NLO_ISA {

/// Returns 1 / n. T(1.0 / n) would use double arithmetic, which few microcontrollers have in hardware.
template <class T>
constexpr T reciprocal(int n) {
  if constexpr (std::is_floating_point_v<T>) {
    return T(1) / T(n);
  } else {
    return T(1.0 / n);
  }
}

/// A complex number. (std::complex would call functions of the compiler's run-time library.) Each product is rounded by
/// itself, so that coefficients that are computed in flight are the same on every target.
template <class T>
struct Complex {
  T re{};
  T im{};

  friend constexpr Complex operator+(Complex a, Complex b) { return {a.re + b.re, a.im + b.im}; }
  friend constexpr Complex operator-(Complex a, Complex b) { return {a.re - b.re, a.im - b.im}; }
  friend constexpr Complex operator*(Complex a, Complex b) {
    return {rounded<T>(a.re * b.re) - rounded<T>(a.im * b.im), rounded<T>(a.re * b.im) + rounded<T>(a.im * b.re)};
  }
  friend constexpr Complex operator*(Complex a, T s) { return {rounded<T>(a.re * s), rounded<T>(a.im * s)}; }
  friend constexpr Complex operator+(Complex a, T s) { return {a.re + s, a.im}; }
};

/// Coefficients of one mode z' = lambda z + u: z+ = z + a_minus_1 z + b0 u_k + b1 u_{k+1}.
/// The stored value is A - 1, not A: for slow modes its float32 error is up to 13 times smaller.
template <class T>
struct ModeStep {
  Complex<T> a_minus_1, b0, b1;
};

/// Scales w by 2^-s with the smallest s such that |re| + |im| <= 1/2. Validated models have |lambda dt| < 1e6 and need
/// at most s = 22. The loop ends for every w; for NaN the result is NaN.
template <class T>
struct Halved {
  static constexpr int kMost = (std::is_floating_point_v<T> ? std::numeric_limits<T>::max_exponent : 1024) + 2;
  Complex<T> w;
  int doublings = 0;

  constexpr explicit Halved(Complex<T> full) : w(full) {
    const auto magnitude = [](Complex<T> c) { return (c.re < T(0) ? -c.re : c.re) + (c.im < T(0) ? -c.im : c.im); };
    for (; doublings < kMost && magnitude(w) > T(0.5); ++doublings) w = w * T(0.5);
  }
};

/// exp(w) - 1, phi_1(w) = (exp(w) - 1) / w and phi_2(w) = (phi_1(w) - 1) / w, without cancellation and without libm:
/// Taylor series at w / 2^s, then s doublings. Relative error: below 3 rounding units for real w <= 0, below 2 (1 +
/// |w|) rounding units for complex w. The rounding of w itself contributes |w| of these units. Source: Higham,
/// Functions of Matrices, section 10.7.4.
template <class T>
struct Phi {
  Complex<T> exp_minus_1, phi1, phi2;

  static constexpr Phi at(Complex<T> full) {
    auto [w, doublings] = Halved<T>(full);
    // phi_2 = sum w^k / (k + 2)!: 0.5^15 / 17! is below the rounding of a double.
    constexpr int kTerms = 15;
    Complex<T> series{T(1), T(0)};
    for (int k = kTerms; k >= 1; --k) series = w * series * reciprocal<T>(k + 2) + T(1);
    Phi p{};
    p.phi2 = series * T(0.5);
    p.phi1 = w * p.phi2 + T(1);
    p.exp_minus_1 = w * p.phi1;
    for (; doublings > 0; --doublings) {
      p.phi2 = (p.phi1 * p.phi1 + p.phi2 * T(2)) * T(0.25);
      p.phi1 = p.phi1 * (p.exp_minus_1 + T(2)) * T(0.5);
      p.exp_minus_1 = p.exp_minus_1 * (p.exp_minus_1 + T(2));
    }
    return p;
  }
};

/// Returns exp(-v) - 1 for any v >= 0; -1 for NaN.
template <class T>
constexpr T decay_minus_1(T v) {
  constexpr T kFar = T(64);  // e^-64 is below any rounding of 1
  return Phi<T>::at({v < kFar ? -v : -kFar, T(0)}).exp_minus_1.re;
}

/// Returns the coefficients of one mode over a step of h; lambda [1/s], h [s].
template <class T>
constexpr ModeStep<T> discretise(Hold hold, Complex<T> lambda, T h) {
  const Complex<T> w = lambda * h;
  if (hold == Hold::kRk4) {  // z' = lambda z + u; u in the middle of the step is the mean of its ends
    const Complex<T> w2 = w * w;
    const Complex<T> w3 = w2 * w;
    return {w * ((w2 * w) * T(1.0 / 24) + w2 * T(1.0 / 6) + w * T(0.5) + T(1)),
            (w3 * T(0.25) + w2 * T(0.75) + w * T(2) + T(3)) * (h * T(1.0 / 6)),
            (w2 * T(0.25) + w + T(3)) * (h * T(1.0 / 6))};
  }
  const Phi<T> p = Phi<T>::at(w);
  if (hold == Hold::kZeroOrder) return {p.exp_minus_1, p.phi1 * h, {T(0), T(0)}};
  return {p.exp_minus_1, (p.phi1 - p.phi2) * h, p.phi2 * h};
}

/// Coefficients of all modes over one step. Rows are latent states: (re, im) of each pair, then the real modes.
template <class Scalar, int kNz, int kNy>
struct LatentStep {
  Scalar a_minus_1[kNz];
  Scalar b0[kNz][kNy];
  Scalar b1[kNz][kNy];
};

/// Returns the coefficients for D (given by its eigenvalues, in the order of the rows) and F over a step of h seconds.
template <int kPairs, class Scalar, int kNz, int kNy>
constexpr LatentStep<Scalar, kNz, kNy> discretise(Hold hold, const Scalar (&eigenvalues)[kNz],
                                                  const Scalar (&output_injection)[kNz][kNy], Scalar h) {
  LatentStep<Scalar, kNz, kNy> step{};
  for (int r = 0; r < 2 * kPairs; r += 2) {
    const auto mode = discretise(hold, Complex<Scalar>{eigenvalues[r], eigenvalues[r + 1]}, h);
    step.a_minus_1[r] = mode.a_minus_1.re;
    step.a_minus_1[r + 1] = mode.a_minus_1.im;
    for (int j = 0; j < kNy; ++j) {
      const Complex<Scalar> f{output_injection[r][j], output_injection[r + 1][j]};
      const Complex<Scalar> b0 = mode.b0 * f;
      const Complex<Scalar> b1 = mode.b1 * f;
      step.b0[r][j] = b0.re;
      step.b0[r + 1][j] = b0.im;
      step.b1[r][j] = b1.re;
      step.b1[r + 1][j] = b1.im;
    }
  }
  for (int r = 2 * kPairs; r < kNz; ++r) {
    const auto mode = discretise(hold, Complex<Scalar>{eigenvalues[r], Scalar(0)}, h);
    step.a_minus_1[r] = mode.a_minus_1.re;
    for (int j = 0; j < kNy; ++j) {
      step.b0[r][j] = mode.b0.re * output_injection[r][j];
      step.b1[r][j] = mode.b1.re * output_injection[r][j];
    }
  }
  return step;
}

inline namespace native {
using simd::broadcast;
#define NLO_CODE
#include "nlo/kernels/per_isa/recurrence.inc"
#undef NLO_CODE
}  // namespace native

}  // namespace nlo::inline NLO_ISA
