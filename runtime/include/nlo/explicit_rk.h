// SPDX-License-Identifier: MIT
// Explicit Runge-Kutta methods for observers whose latent system is not linear. (A linear one is stepped exactly, see
// latent.h.) A method is a Butcher tableau; one function steps them all.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/latent.h"

namespace nlo::inline NLO_ISA {

/// c | a      slopes k_i = f(t + c_i h, z + h sum_j a_ij k_j), j < i
///   | b      z+ = z + h sum_i b_i k_i
template <class Scalar, int kStages_>
struct Tableau {
  static constexpr int kStages = kStages_;
  int order;
  Scalar a[kStages][kStages];
  Scalar b[kStages];
  Scalar c[kStages];
};

template <class Scalar>
inline constexpr Tableau<Scalar, 1> kEuler = {.order = 1, .a = {{0}}, .b = {1}, .c = {0}};

template <class Scalar>
inline constexpr Tableau<Scalar, 2> kHeun = {
    .order = 2, .a = {{0, 0}, {1, 0}}, .b = {Scalar(0.5), Scalar(0.5)}, .c = {0, 1}};

/// The classical method. Stable on z' = lambda z for real lambda h > -2.78.
template <class Scalar>
inline constexpr Tableau<Scalar, 4> kRk4 = {
    .order = 4,
    .a = {{0, 0, 0, 0}, {Scalar(0.5), 0, 0, 0}, {0, Scalar(0.5), 0, 0}, {0, 0, 1, 0}},
    .b = {Scalar(1.0 / 6), Scalar(1.0 / 3), Scalar(1.0 / 3), Scalar(1.0 / 6)},
    .c = {0, Scalar(0.5), Scalar(0.5), 1}};

/// One step of length h: z <- z + h sum_i b_i k_i, in place.
///   slope(c, z, dz)  computes dz = f(t + c h, z)
template <Arithmetic kArithmetic = Arithmetic::kFast, class Scalar, int kStages, int kN, class Slope>
void explicit_rk_step(const Tableau<Scalar, kStages>& tableau, Scalar h, Scalar (&z)[kN], const Slope& slope) {
  Scalar k[kStages][kN];
  for (int i = 0; i < kStages; ++i) {
    Scalar at[kN];
    for (int r = 0; r < kN; ++r) {
      Scalar change{};
      for (int j = 0; j < i; ++j) change = multiply_add<kArithmetic>(tableau.a[i][j], k[j][r], change);
      at[r] = multiply_add<kArithmetic>(h, change, z[r]);
    }
    slope(tableau.c[i], at, k[i]);
  }
  for (int r = 0; r < kN; ++r) {
    Scalar change{};
    for (int i = 0; i < kStages; ++i) change = multiply_add<kArithmetic>(tableau.b[i], k[i][r], change);
    z[r] = multiply_add<kArithmetic>(h, change, z[r]);
  }
}

/// A gap between samples is stepped in pieces of about one sample period (at most 1.5), and in at most this many. The
/// limit bounds the time of a step. After a longer gap the estimate would be worthless.
inline constexpr int kMostPieces = 64;

/// Returns the number of pieces for a step over dt_s, in (0, kMostPieces sample periods].
template <class Scalar>
constexpr int pieces_of(Scalar dt_s, Scalar sample_period_s) {
  const Scalar periods = dt_s / sample_period_s + Scalar(0.5);
  if (!(periods < Scalar(kMostPieces))) return kMostPieces;  // too large for an int, or NaN
  return periods < Scalar(1) ? 1 : static_cast<int>(periods);
}

/// Interpolates between two samples: constant, or a ramp that is exact at both ends.
///   part  position in the interval, in [0, 1]
template <Arithmetic kArithmetic = Arithmetic::kFast, class Scalar, int kN>
constexpr void between(Hold hold, const Scalar (&from)[kN], const Scalar (&to)[kN], Scalar part, Scalar (&value)[kN]) {
  if (hold == Hold::kZeroOrder) part = Scalar(0);
  for (int j = 0; j < kN; ++j) {
    value[j] = multiply_add<kArithmetic>(part, to[j], rounded<Scalar>((Scalar(1) - part) * from[j]));
  }
}

/// Advances z over the interval between two samples by RK4, in pieces of about one sample period.
///   model  has sample_period_s, hold and slope(z, y, dz), which is a template on the policy
///   dt_s   the interval [s]; 0: one sample period
template <Arithmetic kArithmetic = Arithmetic::kFast, class Model, class Scalar, int kNz, int kNy>
void integrate(const Model& model, Scalar (&z)[kNz], const Scalar (&y)[kNy], const Scalar (&y_next)[kNy], Scalar dt_s) {
  const int pieces = dt_s == Scalar(0) ? 1 : pieces_of(dt_s, model.sample_period_s);
  const Scalar share = Scalar(1) / static_cast<Scalar>(pieces);
  const Scalar h = (dt_s == Scalar(0) ? model.sample_period_s : dt_s) * share;
  for (int i = 0; i < pieces; ++i) {
    const auto before = static_cast<Scalar>(i);
    explicit_rk_step<kArithmetic>(kRk4<Scalar>, h, z, [&](Scalar c, const Scalar(&at)[kNz], Scalar(&dz)[kNz]) {
      Scalar y_now[kNy];
      between<kArithmetic>(model.hold, y, y_next, rounded<Scalar>((before + c) * share), y_now);
      model.template slope<kArithmetic>(at, y_now, dz);
    });
  }
}

}  // namespace nlo::inline NLO_ISA
