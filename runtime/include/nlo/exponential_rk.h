// SPDX-License-Identifier: MIT
// One step of z' = D z + F y + N(z, t) by the exponential scheme ETD4RK-B of Krogstad: exact in D and F y, of order 4
// in N. With N = 0 it is the recurrence of latent.h. Two simpler schemes are not good enough:
// - Plain RK4 is unstable for |lambda h| > 2.78, and observers have such fast poles.
// - An integrating factor is stable, but its steady state for a constant N is wrong, by 70 % at lambda h = -10. The
//   steady state of this scheme is exact.
// Source: Krogstad, Generalized integrating factor methods for stiff PDEs, J. Comput. Phys. 203 (2005).
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/latent.h"

namespace nlo::inline NLO_ISA {

/// exp(w) - 1 and phi_1, phi_2, phi_3 of w: Phi with one more function, phi_3(w) = (phi_2(w) - 1/2) / w.
template <class T>
struct ForcedPhi {
  Complex<T> exp_minus_1, phi1, phi2, phi3;

  /// Returns the functions at 2 w.
  constexpr ForcedPhi doubled() const {
    return {exp_minus_1 * (exp_minus_1 + T(2)), phi1 * (exp_minus_1 + T(2)) * T(0.5),
            (phi1 * phi1 + phi2 * T(2)) * T(0.25), (phi1 * phi2 + phi2 + phi3 * T(2)) * T(0.125)};
  }

  static constexpr ForcedPhi at(Complex<T> full) {
    auto [w, doublings] = Halved<T>(full);
    // phi_3 = sum w^k / (k + 3)!: 0.5^14 / 17! is below the rounding of a double.
    constexpr int kTerms = 14;
    Complex<T> series{T(1), T(0)};
    for (int k = kTerms; k >= 1; --k) series = w * series * reciprocal<T>(k + 3) + T(1);
    ForcedPhi p{};
    p.phi3 = series * T(1.0 / 6);
    p.phi2 = w * p.phi3 + T(0.5);
    p.phi1 = w * p.phi2 + T(1);
    p.exp_minus_1 = w * p.phi1;
    for (; doublings > 0; --doublings) p = p.doubled();
    return p;
  }
};

/// Weights of the slopes N_i of N in the stages of one mode:
///   z_2 = z(h/2) + stage2 N_1
///   z_3 = z(h/2) + stage3_1 N_1 + stage3_2 N_2
///   z_4 = z(h)   + stage4_1 N_1 + stage4_3 N_3
///   z+  = z(h)   + end_1 N_1 + end_23 (N_2 + N_3) + end_4 N_4
/// z(h/2) and z(h) are the mode after half a step and after a step with N = 0.
template <class V>
struct ForcedWeights {
  V stage2, stage3_1, stage3_2, stage4_1, stage4_3, end_1, end_23, end_4;
};

/// Returns the weights of the mode z' = lambda z + N over a step of h; lambda [1/s], h [s].
template <class T>
constexpr ForcedWeights<Complex<T>> forced_weights(Complex<T> lambda, T h) {
  const auto half = ForcedPhi<T>::at(lambda * (h * T(0.5)));
  const auto full = half.doubled();
  return {.stage2 = half.phi1 * (h * T(0.5)),
          .stage3_1 = (half.phi1 * T(0.5) - half.phi2) * h,
          .stage3_2 = half.phi2 * h,
          .stage4_1 = (full.phi1 - full.phi2 * T(2)) * h,
          .stage4_3 = full.phi2 * (T(2) * h),
          .end_1 = (full.phi1 - full.phi2 * T(3) + full.phi3 * T(4)) * h,
          .end_23 = (full.phi2 * T(2) - full.phi3 * T(4)) * h,
          .end_4 = (full.phi3 * T(4) - full.phi2) * h};
}

/// One weight for every mode, in the order of the eigenvalues: (re, im) of each pair, then the real ones.
template <class Scalar, int kNz>
struct ModeWeights {
  Scalar values[kNz];
};

/// Coefficients that a step with N needs in addition to those of LatentStep.
template <class Scalar, int kNz, int kNy>
struct ForcedStep {
  LatentStep<Scalar, kNz, kNy> half;  ///< D and F over half a step
  ForcedWeights<ModeWeights<Scalar, kNz>> weights;
};

/// Returns the coefficients for D (given by its eigenvalues) and F over a step of h seconds. `hold` is not kRk4.
template <int kPairs, class Scalar, int kNz, int kNy>
constexpr ForcedStep<Scalar, kNz, kNy> forced_step(Hold hold, const Scalar (&eigenvalues)[kNz],
                                                   const Scalar (&output_injection)[kNz][kNy], Scalar h) {
  ForcedStep<Scalar, kNz, kNy> step{};
  step.half = discretise<kPairs>(hold, eigenvalues, output_injection, h * Scalar(0.5));
  for (int r = 0; r < kNz; ++r) {
    const bool paired = r < 2 * kPairs;
    const auto mode = forced_weights(Complex<Scalar>{eigenvalues[r], paired ? eigenvalues[r + 1] : Scalar(0)}, h);
    const auto set = [&](ModeWeights<Scalar, kNz>& weights, const Complex<Scalar>& value) {
      weights.values[r] = value.re;
      if (paired) weights.values[r + 1] = value.im;
    };
    auto& w = step.weights;
    set(w.stage2, mode.stage2);
    set(w.stage3_1, mode.stage3_1);
    set(w.stage3_2, mode.stage3_2);
    set(w.stage4_1, mode.stage4_1);
    set(w.stage4_3, mode.stage4_3);
    set(w.end_1, mode.end_1);
    set(w.end_23, mode.end_23);
    set(w.end_4, mode.end_4);
    if (paired) ++r;
  }
  return step;
}

/// z <- z + weight N, for every mode.
template <int kPairs, Arithmetic kArithmetic = Arithmetic::kFast, class Scalar, int kNz>
constexpr void add_forced(const ModeWeights<Scalar, kNz>& weight, const Scalar (&n)[kNz], Scalar (&z)[kNz]) {
  const auto& w = weight.values;
  for (int r = 0; r < 2 * kPairs; r += 2) {
    z[r] += multiply_add<kArithmetic>(w[r], n[r], -rounded<Scalar>(w[r + 1] * n[r + 1]));
    z[r + 1] += multiply_add<kArithmetic>(w[r + 1], n[r], rounded<Scalar>(w[r] * n[r + 1]));
  }
  for (int r = 2 * kPairs; r < kNz; ++r) z[r] = multiply_add<kArithmetic>(w[r], n[r], z[r]);
}

/// Advances z by one step, in place.
///   step, forced       coefficients of the step
///   y, y_half, y_next  y at the start, the middle and the end of the step
///   slope(c, z, n)     computes n = N(z, t + c h), c in [0, 1]
template <int kPairs, Arithmetic kArithmetic = Arithmetic::kFast, class Scalar, int kNz, int kNy, class Slope>
void exponential_rk_step(const LatentStep<Scalar, kNz, kNy>& step, const ForcedStep<Scalar, kNz, kNy>& forced,
                         Scalar (&z)[kNz], const Scalar (&y)[kNy], const Scalar (&y_half)[kNy],
                         const Scalar (&y_next)[kNy], const Slope& slope) {
  const auto& w = forced.weights;
  Scalar half[kNz], full[kNz], at[kNz], n1[kNz], n2[kNz], n3[kNz], n4[kNz];
  for (int r = 0; r < kNz; ++r) half[r] = full[r] = z[r];
  advance<kPairs, kArithmetic>(forced.half, half, y, y_half);
  advance<kPairs, kArithmetic>(step, full, y, y_next);
  const auto start_at = [&at](const Scalar(&from)[kNz]) {
    for (int r = 0; r < kNz; ++r) at[r] = from[r];
  };

  slope(Scalar(0), z, n1);
  start_at(half);
  add_forced<kPairs, kArithmetic>(w.stage2, n1, at);
  slope(Scalar(0.5), at, n2);
  start_at(half);
  add_forced<kPairs, kArithmetic>(w.stage3_1, n1, at);
  add_forced<kPairs, kArithmetic>(w.stage3_2, n2, at);
  slope(Scalar(0.5), at, n3);
  start_at(full);
  add_forced<kPairs, kArithmetic>(w.stage4_1, n1, at);
  add_forced<kPairs, kArithmetic>(w.stage4_3, n3, at);
  slope(Scalar(1), at, n4);

  for (int r = 0; r < kNz; ++r) {
    z[r] = full[r];
    n2[r] += n3[r];
  }
  add_forced<kPairs, kArithmetic>(w.end_1, n1, z);
  add_forced<kPairs, kArithmetic>(w.end_23, n2, z);
  add_forced<kPairs, kArithmetic>(w.end_4, n4, z);
}

}  // namespace nlo::inline NLO_ISA
