// SPDX-License-Identifier: MIT
// The observer with a prior: an extended Kalman filter with the known equations of the plant, and learned gated units
// that set its noise variances and correct its estimate.
//   x-  = one RK4 step of dx/dt = f(x, u) from x         the prior; P- likewise by dP/dt = F P + P F', F = df/dx
//   nu  = y - h(x-, u)                                   the innovation; 0 for an output that has not arrived
//   w   = [s(nu, fine); s(nu, coarse); y; u; x-]         s(v, c) = v / (c + |v|), between -1 and 1
//   m   states of gated units (gated_observer.h) that read w instead of y
//   [K; b; c_q; c_r] = correction([m; w])
//   x, P  measurement update (covariance.h) with q = state_noise exp(c_q), r = output_noise exp(c_r), by the outputs
//         that have arrived
//   x  <- x + K s(nu, coarse) + b
//   x_hat = T*([m; x; p]),   z = [m; x; p],   p: the upper triangle of P
// With n_m = 0 nothing is learned: K, b, c_q and c_r are 0, and the observer is the extended Kalman filter itself.
// x has the n_x estimated states, then the plant's states that are not estimated: n_s states.
// x and p are limited to a range from which no step overflows. Therefore one outlier cannot move x to where f was never
// evaluated. Stalenesses are read beside y.
#pragma once

#include <cstdint>
#include <limits>
#include <type_traits>

#include "nlo/covariance.h"
#include "nlo/explicit_rk.h"
#include "nlo/functions.h"
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

/// Takes the place of a field that a filter without units does not have. Each field has a type of its own, because two
/// empty fields of one type would take up space.
template <int>
struct NoUnits {
  static constexpr int kIn = 0, kOut = 0;
};

/// The constants of an observer. A generated header defines them: `inline constexpr Model kModel`.
///   Equations  derivative(x, u, dx) computes d[x; p]/dt. output(x, y), or output(x, u, y) if an output depends on an
///              input, writes the n_y outputs and then dh/dx row by row. Each operation is rounded by itself, so that
///              the bits are the same on every target
template <class Scalar_, int kNx_, int kNy_, int kUnits_, class Equations_, class Gates_, class Candidate_,
          class Correction_, class InverseMap_, int kNu_ = 0, Hold kInputHold_ = Hold::kZeroOrder, int kNf_ = 0>
struct PriorModel {
  using Scalar = Scalar_;
  using Equations = Equations_;
  using Gates = Gates_;
  using Candidate = Candidate_;
  using Correction = Correction_;
  using InverseMap = InverseMap_;
  static constexpr int kNx = kNx_;
  static constexpr int kStates = [] {  ///< n_s
    if constexpr (requires { Equations::kStates; })
      return int{Equations::kStates};
    else
      return kNx_;
  }();
  static constexpr int kNy = kNy_;
  static constexpr int kUnits = kUnits_;                             ///< n_m
  static constexpr int kCarried = kStates + triangle_size(kStates);  ///< [x; p]
  static constexpr int kNz = kUnits + kCarried;
  static constexpr int kNu = kNu_;
  static constexpr int kNf = kNf_;                        ///< outputs that may be missing
  static constexpr int kNr = kNy + kNu + kNf;             ///< readings: outputs, inputs, stalenesses of the kNf outputs
  static constexpr int kReads = 2 * kNy + kNr + kStates;  ///< n_w
  static constexpr Hold kInputHold = kInputHold_;
  static constexpr int kLongestGap = kMostPieces;
  static constexpr bool kHasSteadyState = false;
  static constexpr bool kMayDiverge = false;
  static constexpr bool kReadsArrivals = true;  ///< start() and advance() are told which outputs have arrived
  static_assert(kNx > 0 && kStates >= kNx && kNy > 0 && kUnits >= 0 && kNu >= 0);
  static constexpr int kIn = kUnits > 0 ? kUnits + kReads : 0;                   ///< [m; w]
  static constexpr int kCorrections = kUnits > 0 ? kStates*(kNy + 2) + kNy : 0;  ///< [K; b; c_q; c_r]
  static_assert(Gates::kIn == kIn && Gates::kOut == 2 * kUnits, "gates map [m; w] to 2 n_m");
  static_assert(Candidate::kIn == kIn && Candidate::kOut == kUnits, "the candidate maps [g m; w] to n_m");
  static_assert(Correction::kIn == kIn && Correction::kOut == kCorrections, "[m; w] to K, b, c_q and c_r");
  static_assert(InverseMap::kOut == kNx, "T* ends in n_x outputs");
  static_assert(InverseMap::kIn == kNz || InverseMap::kIn == kNz + kNr, "T* reads z, or z and the latest y");

  template <int kField>
  using Squashing = std::conditional_t<(kUnits > 0), Scalar[kNy], NoUnits<kField>>;

  Scalar sample_period_s;
  std::uint16_t stale_after;                        ///< after this many held measurements in a row: kStale
  Scalar initial[kNz];                              ///< [m; x; p] before the first measurement
  Scalar state_min[kCarried], state_max[kCarried];  ///< limits of [x; p]
  [[no_unique_address]] Squashing<0> fine{};        ///< n_y: innovations at which s(nu, fine) is 1/2
  [[no_unique_address]] Squashing<1> coarse{};      ///< n_y: innovations at which s(nu, coarse) is 1/2
  Scalar state_noise[kStates], output_noise[kNy];   ///< variances at c_q = 0 (per sample period) and c_r = 0
  ReadingRange<Scalar, kNr> outputs;                ///< ranges of all readings
  Domain<Scalar, kNz> domain;
  [[no_unique_address]] Gates gates{};            ///< layer that computes [a_s; a_g]
  [[no_unique_address]] Candidate candidate{};    ///< layer that computes the argument of the tanh
  [[no_unique_address]] Correction correction{};  ///< layer that computes K row by row, then b, c_q, c_r
  InverseMap inverse_map;                         ///< T*
  [[no_unique_address]] SensorFailures<Scalar, kNf> failures{};

  constexpr const Scalar (&initial_latent() const)[kNz] { return initial; }

  /// Corrects the initial state by the outputs of the first sample that have arrived.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void start(const Scalar (&y)[kNr], const Vector<bool, kNy>& arrived, Scalar (&z)[kNz]) const {
    correct<kArithmetic, true>(z, y, arrived, Scalar(1));
  }

  /// Advances z over dt_s seconds (0: one sample period) with the measurement at the end. A longer step takes several
  /// steps of RK4.
  ///   arrived  outputs that were measured; y_next holds the last value of the others
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  NLO_INLINE void advance(Scalar (&z)[kNz], const Scalar (&y)[kNr], const Scalar (&y_next)[kNr],
                          const Vector<bool, kNy>& arrived, Scalar dt_s) const {
    if (dt_s == Scalar(0)) {
      predict<kArithmetic>(z, y, y_next, sample_period_s, 1);
      correct<kArithmetic, true>(z, y_next, arrived, Scalar(1));
    } else {
      const int pieces = pieces_of(dt_s, sample_period_s);
      predict<kArithmetic>(z, y, y_next, dt_s / static_cast<Scalar>(pieces), pieces);
      correct<kArithmetic, false>(z, y_next, arrived, dt_s / sample_period_s);
    }
  }

  /// x_hat = T*(z) or T*(z, y). log2_sigma, n_x: see error_head.h.
  template <Arithmetic kArithmetic = Arithmetic::kFast, class... Log2Sigma>
  void estimate(const Scalar (&z)[kNz], const Scalar (&y)[kNr], Scalar (&x_hat)[kNx], Log2Sigma*... log2_sigma) const {
    evaluate_inverse<kArithmetic>(inverse_map, z, y, &x_hat[0], log2_sigma...);
  }

 private:
  /// Limits element i of [x; p] to its range. NaN stays NaN, so that the step detects a corrupted state.
  template <Arithmetic kArithmetic>
  NLO_INLINE Scalar kept_within(Scalar x, int i) const {
    const Scalar below = select<kArithmetic>(!(x > state_max[i]), x, state_max[i]);
    return select<kArithmetic>(!(below < state_min[i]), below, state_min[i]);
  }

  /// Returns NaN for a value that no sound step produces, such as after a bit flip or a division by 0. Limiting it to
  /// the range would hide the corruption.
  template <Arithmetic kArithmetic>
  NLO_INLINE static Scalar possible(Scalar x) {
    return select<kArithmetic>(is_below(x, Scalar(0x1p100)), x, std::numeric_limits<Scalar>::quiet_NaN());
  }

  /// Replaces x and p in z by x- and p-.
  template <Arithmetic kArithmetic>
  void predict(Scalar (&z)[kNz], const Scalar (&y)[kNr], const Scalar (&y_next)[kNr], Scalar h, int pieces) const {
    const Scalar share = Scalar(1) / static_cast<Scalar>(pieces);
    Scalar x[kCarried];
    for (Scalar& value : z) value = possible<kArithmetic>(value);
    for (int r = 0; r < kCarried; ++r) x[r] = z[kUnits + r];
    for (int i = 0; i < pieces; ++i) {
      explicit_rk_step<kArithmetic>(kRk4<Scalar>, h, x, [&](Scalar c, const Scalar(&at)[kCarried], auto& dx) {
        Scalar u[kNu > 0 ? kNu : 1]{};
        const Scalar part = rounded<Scalar>((static_cast<Scalar>(i) + c) * share);
        for (int j = 0; j < kNu; ++j) u[j] = multiply_add<kArithmetic>(part, y_next[kNy + j] - y[kNy + j], y[kNy + j]);
        Equations::derivative(at, u, dx);
      });
      for (int r = 0; r < kCarried; ++r) x[r] = kept_within<kArithmetic>(possible<kArithmetic>(x[r]), r);
    }
    for (int r = 0; r < kCarried; ++r) z[kUnits + r] = x[r];
  }

  /// Replaces [m; x-; p-] by [m; x; p].
  template <Arithmetic kArithmetic, bool kRegular>
  void correct(Scalar (&z)[kNz], const Scalar (&y)[kNr], const Vector<bool, kNy>& arrived, Scalar periods) const {
    Scalar expected[kNy * (1 + kStates)], nu[kNy], q[kStates], r[kNy], change[kStates]{}, learned[kStates]{};
    Scalar *const x = &z[kUnits], *const p = x + kStates;
    if constexpr (requires { Equations::output(x, &y[0], expected); })
      Equations::output(x, &y[kNy], expected);
    else
      Equations::output(x, expected);
    for (int j = 0; j < kNy; ++j) nu[j] = select<kArithmetic>(arrived[j], y[j] - expected[j], Scalar(0));
    for (int i = 0; i < kStates; ++i) q[i] = state_noise[i];
    for (int j = 0; j < kNy; ++j) r[j] = output_noise[j];
    if constexpr (kUnits > 0) learn<kArithmetic, kRegular>(z, y, nu, periods, q, r, learned);
    for (int i = 0; i < kStates; ++i) {
      if constexpr (!kRegular) q[i] = rounded<Scalar>(q[i] * periods);
      p[in_triangle(kStates, i, i)] += q[i];
    }
    for (int j = 0; j < kNy; ++j)
      take_output<kArithmetic>(&expected[kNy + j * kStates], nu[j], r[j], arrived[j], change, p);
    for (int i = 0; i < kStates; ++i) x[i] += change[i] + learned[i];
    for (int i = 0; i < kCarried; ++i) x[i] = kept_within<kArithmetic>(x[i], i);
  }

  /// Steps the units m in z = [m; x-; p-], and lets them correct: multiplies q by exp(c_q) and r by exp(c_r), and
  /// writes K s(nu, coarse) + b to `learned`.
  template <Arithmetic kArithmetic, bool kRegular>
  NLO_INLINE void learn(Scalar (&z)[kNz], const Scalar (&y)[kNr], const Scalar (&nu)[kNy], Scalar periods,
                        Scalar (&q)[kStates], Scalar (&r)[kNy], Scalar (&learned)[kStates]) const {
    LayerBuffer<Scalar, kIn> in;
    GateBuffers<Scalar, kUnits> between;
    Scalar m[kUnits], gain[kCorrections], *const w = &in.values[kUnits];
    for (int u = 0; u < kUnits; ++u) in.values[u] = m[u] = z[u];
    for (int j = 0; j < kNy; ++j) {
      const Scalar size = select<kArithmetic>(nu[j] >= Scalar(0), nu[j], -nu[j]);
      w[j] = nu[j] / (fine[j] + size);
      w[kNy + j] = nu[j] / (coarse[j] + size);
    }
    for (int j = 0; j < kNr; ++j) w[2 * kNy + j] = y[j];
    for (int i = 0; i < kStates; ++i) w[2 * kNy + kNr + i] = z[kUnits + i];
    for (int i = kIn; i < kernels::padded(kIn); ++i) in.values[i] = Scalar(0);
    kernels::gated_step<kArithmetic, kRegular>(gates.mlp.layer, candidate.mlp.layer, in.values, between.gates.values,
                                               between.targets(), m, periods);
    for (int u = 0; u < kUnits; ++u) in.values[u] = z[u] = m[u];
    correction.template evaluate<kArithmetic>(in.values, gain);
    const Scalar *const drift = &gain[kStates * kNy], *const noise = drift + kStates;
    for (int i = 0; i < kStates; ++i) q[i] = rounded<Scalar>(q[i] * noise_of<kArithmetic>(noise[i]));
    for (int j = 0; j < kNy; ++j) r[j] = rounded<Scalar>(r[j] * noise_of<kArithmetic>(noise[kStates + j]));
    for (int i = 0; i < kStates; ++i) {
      learned[i] = drift[i];
      for (int j = 0; j < kNy; ++j) learned[i] = multiply_add<kArithmetic>(gain[i * kNy + j], w[kNy + j], learned[i]);
    }
  }
};

/// An extended Kalman filter: a PriorModel without units.
template <class Scalar, int kNx, int kNy, class Equations, class InverseMap, int kNu = 0,
          Hold kInputHold = Hold::kZeroOrder, int kNf = 0>
using FilterModel =
    PriorModel<Scalar, kNx, kNy, 0, Equations, NoUnits<2>, NoUnits<3>, NoUnits<4>, InverseMap, kNu, kInputHold, kNf>;

/// The observer of a PriorModel. The second parameter chooses the arithmetic, as for KklObserver.
template <class Model, Arithmetic kArithmetic = Arithmetic::kFast>
class PriorObserver : public SampledObserver<Model, kArithmetic> {
 public:
  using SampledObserver<Model, kArithmetic>::SampledObserver;
};
template <class Model>
PriorObserver(const Model&) -> PriorObserver<Model>;

}  // namespace nlo::inline NLO_ISA
