// SPDX-License-Identifier: MIT
// The gated observer: the general observer (11), dz/dt = F(z, y), x_hat = T*(z), with an F that cannot diverge.
//   dz/dt = rate (target - z)     rate > 0, |target| <= 1
//   [a_s; a_g] = gates([z; y]),   rate = softplus(2 a_s) / sample period,   g = (1 + tanh a_g) / 2
//   target = tanh(candidate([g z; y]))
//                                      g: reset gates, which scale the z that the candidate reads
// During a step, rate and target are constant; they are computed from z at its start and the measurement at its end.
// Then the step is exact:
//   z+ = z + (1 - exp(-rate dt)) (target - z),   over one sample period 1 - exp(-rate dt) = (1 + tanh a_s) / 2
// z stays between -1 and 1 for every measurement. Known inputs and stalenesses are read beside y.
#pragma once

#include <cstdint>

#include "nlo/gate.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kkl_observer.h"
#include "nlo/latent.h"
#include "nlo/measurement.h"
#include "nlo/mlp.h"
#include "nlo/observer_state.h"
#include "nlo/sampled_observer.h"
#include "nlo/sensor_failures.h"

namespace nlo::inline NLO_ISA {

/// The constants of an observer. A generated header defines them: `inline constexpr Model kModel`.
template <class Scalar_, int kNx_, int kNy_, int kNz_, class Gates_, class Candidate_, class InverseMap_, int kNu_ = 0,
          Hold kInputHold_ = Hold::kZeroOrder, int kNf_ = 0, class Computed_ = NoComputed>
struct GatedModel {
  using Scalar = Scalar_;
  using Gates = Gates_;
  using Candidate = Candidate_;
  using InverseMap = InverseMap_;
  using Computed = Computed_;  ///< computes the last outputs from the measured ones; NoComputed: all are measured
  static constexpr int kNx = kNx_;
  static constexpr int kNy = kNy_;
  static constexpr int kNz = kNz_;
  static constexpr int kNu = kNu_;
  static constexpr int kNf = kNf_;             ///< outputs that may be missing
  static constexpr int kNr = kNy + kNu + kNf;  ///< readings: outputs, inputs, stalenesses of the kNf outputs
  static constexpr Hold kInputHold = kInputHold_;
  static constexpr int kLongestGap = 1000;
  static constexpr bool kHasSteadyState = false;
  static constexpr bool kMayDiverge = false;
  static_assert(kNx > 0 && kNy > 0 && kNz > 0 && kNu >= 0);
  static_assert(Gates::kIn == kNz + kNr && Gates::kOut == 2 * kNz, "gates map [z; y] to 2 n_z");
  static_assert(Candidate::kIn == kNz + kNr && Candidate::kOut == kNz, "the candidate maps [g z; y] to n_z");
  static_assert(decltype(Gates::mlp)::kLayers == 1 && decltype(Candidate::mlp)::kLayers == 1, "one layer each");
  static_assert(InverseMap::kOut == kNx, "T* ends in n_x outputs");
  static_assert(InverseMap::kIn == kNz || InverseMap::kIn == kNz + kNr, "T* reads z, or z and the latest y");

  Scalar sample_period_s;
  std::uint16_t stale_after;          ///< after this many held measurements in a row the status is kStale
  Scalar initial[kNz];                ///< z before the first measurement
  ReadingRange<Scalar, kNr> outputs;  ///< ranges of all readings
  Domain<Scalar, kNz> domain;
  Gates gates;             ///< layer that computes [a_s; a_g]
  Candidate candidate;     ///< layer that computes the argument of the tanh
  InverseMap inverse_map;  ///< T*
  [[no_unique_address]] SensorFailures<Scalar, kNf> failures{};

  constexpr const Scalar (&initial_latent() const)[kNz] { return initial; }

  /// The first measurement is a step of one sample period.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void start(const Scalar (&y)[kNr], Scalar (&z)[kNz]) const {
    advance<kArithmetic>(z, y, y, Scalar(0));
  }

  /// Advances z over dt_s seconds (0: one sample period) with the measurement at the end. A step that is not one
  /// sample period takes some 200 more operations per unit. Returns true if it has checked that z is reachable.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  NLO_INLINE bool advance(Scalar (&z)[kNz], const Scalar (&)[kNr], const Scalar (&y_next)[kNr], Scalar dt_s) const {
    if (dt_s == Scalar(0)) return step<kArithmetic, true>(z, y_next, Scalar(1));
    return step<kArithmetic, false>(z, y_next, dt_s / sample_period_s);
  }

  /// x_hat = T*(z) or T*(z, y). log2_sigma, n_x: see error_head.h.
  template <Arithmetic kArithmetic = Arithmetic::kFast, class... Log2Sigma>
  void estimate(const Scalar (&z)[kNz], const Scalar (&y)[kNr], Scalar (&x_hat)[kNx], Log2Sigma*... log2_sigma) const {
    evaluate_inverse<kArithmetic>(inverse_map, z, y, &x_hat[0], log2_sigma...);
  }

 private:
  template <Arithmetic kArithmetic, bool kRegular>
  bool step(Scalar (&z)[kNz], const Scalar (&y)[kNr], Scalar periods) const {
    if constexpr (requires { gates.template step<kRegular>(candidate, z, y, periods); }) {
      gates.template step<kRegular>(candidate, z, y, periods);  // quantised_units.h
      return false;
    } else {
      return step_in_scalar<kArithmetic, kRegular>(z, y, periods);
    }
  }

  template <Arithmetic kArithmetic, bool kRegular>
  bool step_in_scalar(Scalar (&z)[kNz], const Scalar (&y)[kNr], Scalar periods) const {
    LayerBuffer<Scalar, kNz + kNr> in;
    GateBuffers<Scalar, kNz> between;
    const bool below_2 = kernels::copy_units<kNz>(z, in.values);  // then z+ is below 2, too, between z and target
    for (int j = 0; j < kNr; ++j) in.values[kNz + j] = y[j];
    for (int i = kNz + kNr; i < kernels::padded(kNz + kNr); ++i) in.values[i] = Scalar(0);
    kernels::gated_step<kArithmetic, kRegular>(gates.mlp.layer, candidate.mlp.layer, in.values, between.gates.values,
                                               between.targets(), z, periods);
    return below_2;
  }
};

/// The observer of a GatedModel. The second parameter chooses the arithmetic, as for KklObserver.
template <class Model, Arithmetic kArithmetic = Arithmetic::kFast>
class GatedObserver : public SampledObserver<Model, kArithmetic> {
 public:
  using SampledObserver<Model, kArithmetic>::SampledObserver;
};
template <class Model>
GatedObserver(const Model&) -> GatedObserver<Model>;

}  // namespace nlo::inline NLO_ISA
