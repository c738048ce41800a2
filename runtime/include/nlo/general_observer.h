// SPDX-License-Identifier: MIT
// The general observer (11): dz/dt = F(z, y), x_hat = G(z), with learned F and G, stepped by the classical Runge-Kutta
// method. Its stability is not proven: a step that would overflow keeps the last z and returns kDiverged.
#pragma once

#include <cstdint>

#include "nlo/explicit_rk.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/latent.h"
#include "nlo/measurement.h"
#include "nlo/mlp.h"
#include "nlo/observer_state.h"
#include "nlo/sampled_observer.h"

namespace nlo::inline NLO_ISA {

/// The constants of an observer. A generated header defines them: `inline constexpr Model kModel`.
template <class Scalar_, int kNx_, int kNy_, int kNz_, class Dynamics_, class InverseMap_, int kNu_ = 0,
          Hold kInputHold_ = Hold::kZeroOrder>
struct GeneralModel {
  using Scalar = Scalar_;
  using Dynamics = Dynamics_;
  using InverseMap = InverseMap_;
  static constexpr int kNx = kNx_;
  static constexpr int kNy = kNy_;
  static constexpr int kNz = kNz_;
  static constexpr int kNu = kNu_;
  static constexpr int kNf = 0;
  static constexpr int kNr = kNy + kNu;  ///< readings: outputs, then inputs
  static constexpr Hold kInputHold = kInputHold_;
  static constexpr int kLongestGap = kMostPieces;
  static constexpr bool kHasSteadyState = false;
  static constexpr bool kMayDiverge = true;
  static_assert(kNx > 0 && kNy > 0 && kNz > 0);
  static_assert(Dynamics::kIn == kNz + kNr && Dynamics::kOut == kNz, "F maps [z; y], or [z; y; u], to n_z");
  static_assert(InverseMap::kIn == kNz && InverseMap::kOut == kNx, "G maps n_z to n_x");

  Scalar sample_period_s;
  std::uint16_t stale_after;          ///< after this many held measurements in a row the status is kStale
  Hold hold;                          ///< y between samples: kZeroOrder, or a ramp
  Scalar initial[kNz];                ///< z before the first measurement
  ReadingRange<Scalar, kNr> outputs;  ///< ranges of outputs and inputs
  Domain<Scalar, kNz> domain;
  Dynamics dynamics;       ///< F
  InverseMap inverse_map;  ///< G

  constexpr const Scalar (&initial_latent() const)[kNz] { return initial; }

  /// Advances z over dt_s seconds (0: one sample period), in pieces of about one sample period.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void advance(Scalar (&z)[kNz], const Scalar (&y)[kNr], const Scalar (&y_next)[kNr], Scalar dt_s) const {
    integrate<kArithmetic>(*this, z, y, y_next, dt_s);
  }

  /// dz/dt = F(z, y).
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void slope(const Scalar (&z)[kNz], const Scalar (&y)[kNr], Scalar (&dz)[kNz]) const {
    Scalar in[kNz + kNr];
    for (int r = 0; r < kNz; ++r) in[r] = z[r];
    for (int j = 0; j < kNr; ++j) in[kNz + j] = y[j];
    dynamics.template evaluate<kArithmetic>(in, dz);
  }

  /// x_hat = G(z). log2_sigma, n_x: see error_head.h.
  template <Arithmetic kArithmetic = Arithmetic::kFast, class... Log2Sigma>
  void estimate(const Scalar (&z)[kNz], const Scalar (&)[kNr], Scalar (&x_hat)[kNx], Log2Sigma*... log2_sigma) const {
    inverse_map.template evaluate<kArithmetic>(z, x_hat, log2_sigma...);
  }
};

/// The observer of a GeneralModel. The second parameter chooses the arithmetic, as for KklObserver.
template <class Model, Arithmetic kArithmetic = Arithmetic::kFast>
class GeneralObserver : public SampledObserver<Model, kArithmetic> {
 public:
  using SampledObserver<Model, kArithmetic>::SampledObserver;
};
template <class Model>
GeneralObserver(const Model&) -> GeneralObserver<Model>;

}  // namespace nlo::inline NLO_ISA
