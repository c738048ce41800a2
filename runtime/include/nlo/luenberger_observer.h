// SPDX-License-Identifier: MIT
// Luenberger-like observer (15) of a partially known plant, dx/dt = A x + g(x), y = C x, with a learned g_hat:
//   x_hat' = A x_hat + g_hat(x_hat) + G (y - C x_hat)
// stepped by the classical Runge-Kutta method. Its latent state is the estimate. Export checks that A - G C is Hurwitz
// and within the stable region of the method. Only an evaluation shows whether the observer is stable with g_hat.
#pragma once

#include <cstdint>

#include "nlo/explicit_rk.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/latent.h"
#include "nlo/measurement.h"
#include "nlo/mlp.h"
#include "nlo/observer_state.h"
#include "nlo/sampled_observer.h"

namespace nlo::inline NLO_ISA {

/// The constants of an observer. A generated header defines them: `inline constexpr Model kModel`.
template <class Scalar_, int kNx_, int kNy_, class Nonlinearity_, int kNu_ = 0, Hold kInputHold_ = Hold::kZeroOrder>
struct LuenbergerModel {
  using Scalar = Scalar_;
  using Nonlinearity = Nonlinearity_;
  static constexpr int kNx = kNx_;
  static constexpr int kNy = kNy_;
  static constexpr int kNz = kNx;
  static constexpr int kNu = kNu_;
  static constexpr int kNf = 0;
  static constexpr int kNr = kNy + kNu;  ///< readings: outputs, then inputs
  static constexpr Hold kInputHold = kInputHold_;
  static constexpr int kLongestGap = kMostPieces;
  static constexpr bool kHasSteadyState = false;
  static constexpr bool kMayDiverge = true;
  static_assert(kNx > 0 && kNy > 0);
  static_assert(Nonlinearity::kIn == kNx && Nonlinearity::kOut == kNx, "g_hat maps n_x to n_x");

  Scalar sample_period_s;
  std::uint16_t stale_after;          ///< after this many held measurements in a row the status is kStale
  Hold hold;                          ///< y between samples: kZeroOrder, or a ramp
  Scalar error_matrix[kNx][kNx];      ///< A - G C: the error obeys e' = (A - G C) e if g_hat = g is constant
  Scalar gain[kNx][kNr];              ///< G, or [G, B] with inputs
  Scalar initial[kNx];                ///< x_hat before the first measurement
  ReadingRange<Scalar, kNr> outputs;  ///< ranges of outputs and inputs
  Domain<Scalar, kNx> domain;
  Nonlinearity nonlinearity;  ///< g_hat

  constexpr const Scalar (&initial_latent() const)[kNx] { return initial; }

  /// Advances x_hat over dt_s seconds (0: one sample period), in pieces of about one sample period.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void advance(Scalar (&x_hat)[kNx], const Scalar (&y)[kNr], const Scalar (&y_next)[kNr], Scalar dt_s) const {
    integrate<kArithmetic>(*this, x_hat, y, y_next, dt_s);
  }

  /// Computes dx_hat/dt at x_hat and y.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void slope(const Scalar (&x_hat)[kNx], const Scalar (&y)[kNr], Scalar (&dx_hat)[kNx]) const {
    nonlinearity.template evaluate<kArithmetic>(x_hat, dx_hat);
    for (int i = 0; i < kNx; ++i) {
      for (int k = 0; k < kNx; ++k) dx_hat[i] = multiply_add<kArithmetic>(error_matrix[i][k], x_hat[k], dx_hat[i]);
      for (int j = 0; j < kNr; ++j) dx_hat[i] = multiply_add<kArithmetic>(gain[i][j], y[j], dx_hat[i]);
    }
  }

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void estimate(const Scalar (&z)[kNx], const Scalar (&)[kNr], Scalar (&x_hat)[kNx]) const {
    for (int i = 0; i < kNx; ++i) x_hat[i] = z[i];
  }
};

/// The observer of a LuenbergerModel. The second parameter chooses the arithmetic, as for KklObserver.
template <class Model, Arithmetic kArithmetic = Arithmetic::kFast>
class LuenbergerObserver : public SampledObserver<Model, kArithmetic> {
 public:
  using SampledObserver<Model, kArithmetic>::SampledObserver;
};
template <class Model>
LuenbergerObserver(const Model&) -> LuenbergerObserver<Model>;

}  // namespace nlo::inline NLO_ISA
