// SPDX-License-Identifier: MIT
// Driven KKL observer (24)-(25) of dx/dt = f(x) + g(x) u with known inputs u:
//   dz/dt = D z + F y + phi(z) u,   phi(z) u = dT/dx(x_hat) g(x_hat) u,   x_hat = T*(z)
// phi(z) u is the product of the Jacobian of T and one vector. One forward-mode pass computes it (jvp.h); the Jacobian
// itself is never formed. D z + F y is stepped exactly, phi(z) u at order 4 (exponential_rk.h). With u = 0 this is the
// plain KKL observer.
//
//   observer.step(read_position(), torque);   // with input_hold kZeroOrder: the torque since the last sample
#pragma once

#include <cstdint>

#include "nlo/acting_inputs.h"
#include "nlo/explicit_rk.h"
#include "nlo/exponential_rk.h"
#include "nlo/jvp.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/kkl_observer.h"
#include "nlo/latent.h"
#include "nlo/measurement.h"
#include "nlo/mlp.h"
#include "nlo/observer_state.h"
#include "nlo/sampled_observer.h"

namespace nlo::inline NLO_ISA {

/// Input field of the plant: g(x) u = sum_i u_i (constant_i + linear_i x).
template <class Scalar, int kNx, int kNu>
struct InputField {
  Scalar constant[kNu][kNx];
  Scalar linear[kNu][kNx][kNx];  ///< zero if the effect of the inputs does not depend on x

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  constexpr void apply(const Scalar (&x)[kNx], const Scalar (&u)[kNu], Scalar (&dx)[kNx]) const {
    for (int k = 0; k < kNx; ++k) {
      dx[k] = Scalar(0);
      for (int i = 0; i < kNu; ++i) {
        Scalar g = constant[i][k];
        for (int l = 0; l < kNx; ++l) g = multiply_add<kArithmetic>(linear[i][k][l], x[l], g);
        dx[k] = multiply_add<kArithmetic>(g, u[i], dx[k]);
      }
    }
  }
};

/// The constants of an observer. A generated header defines them: `inline constexpr Model kModel`.
template <class Scalar_, int kNx_, int kNy_, int kNz_, int kNu_, int kPairs_, class InverseMap_, class ForwardMap_>
struct DrivenKklModel {
  using Scalar = Scalar_;
  using InverseMap = InverseMap_;
  using ForwardMap = ForwardMap_;
  static constexpr int kNx = kNx_;
  static constexpr int kNy = kNy_;
  static constexpr int kNz = kNz_;
  static constexpr int kNu = kNu_;
  static constexpr int kNf = 0;
  static constexpr int kNr = kNy;  ///< F and T* read outputs alone
  static constexpr int kPairs = kPairs_;
  static constexpr int kLongestGap = kMostPieces;
  static constexpr bool kHasSteadyState = true;
  static constexpr bool kMayDiverge = true;
  static_assert(kNx > 0 && kNy > 0 && kNz > 0 && kNu > 0 && kPairs >= 0 && 2 * kPairs <= kNz);
  static_assert(InverseMap::kOut == kNx, "T* ends in n_x outputs");
  static_assert(InverseMap::kIn == kNz || InverseMap::kIn == kNz + kNy, "T* reads z, or z and the latest y");
  static_assert(ForwardMap::kIn == kNx && ForwardMap::kOut == kNz, "T maps n_x to n_z");

  Scalar sample_period_s;
  std::uint16_t stale_after;  ///< after this many held measurements in a row the status is kStale
  Hold input_hold;  ///< u between samples: kZeroOrder: the new u; kFirstOrder: a ramp from the last u to the new u
  LatentModel<Scalar, kNz, kNy> latent;
  ForcedStep<Scalar, kNz, kNy> forced;  ///< coefficients for phi(z) u over one sample period
  ReadingRange<Scalar, kNy> outputs;
  Domain<Scalar, kNz> domain;
  InputField<Scalar, kNx, kNu> input_field;  ///< g
  InverseMap inverse_map;                    ///< T*
  ForwardMap forward_map;                    ///< T

  constexpr const Scalar (&initial_latent() const)[kNz] { return latent.initial; }

  /// Advances z over dt_s seconds (0: one sample period), in pieces of about one sample period.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void advance(Scalar (&z)[kNz], const Scalar (&y)[kNy], const Scalar (&y_next)[kNy], const Scalar (&u)[kNu],
               const Scalar (&u_next)[kNu], Scalar dt_s) const {
    if (dt_s == Scalar(0)) return advance_by<kArithmetic>(1, latent.step, forced, z, y, y_next, u, u_next);
    const int pieces = pieces_of(dt_s, sample_period_s);
    const Scalar h = dt_s / static_cast<Scalar>(pieces);
    const Hold hold = latent.exact_hold();
    advance_by<kArithmetic>(pieces, discretise<kPairs>(hold, latent.eigenvalues, latent.output_injection, h),
                            forced_step<kPairs>(hold, latent.eigenvalues, latent.output_injection, h), z, y, y_next, u,
                            u_next);
  }

  /// dz = phi(z) u.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  void drive(const Scalar (&z)[kNz], const Scalar (&y)[kNy], const Scalar (&u)[kNu], Scalar (&dz)[kNz]) const {
    Scalar x_hat[kNx], dx[kNx];
    evaluate_inverse<kArithmetic>(inverse_map, z, y, x_hat);
    input_field.template apply<kArithmetic>(x_hat, u, dx);
    jvp<kArithmetic>(forward_map, x_hat, dx, dz);
  }

  /// x_hat = T*(z) or T*(z, y). log2_sigma, n_x: see error_head.h.
  template <Arithmetic kArithmetic = Arithmetic::kFast, class... Log2Sigma>
  void estimate(const Scalar (&z)[kNz], const Scalar (&y)[kNy], Scalar (&x_hat)[kNx], Log2Sigma*... log2_sigma) const {
    evaluate_inverse<kArithmetic>(inverse_map, z, y, &x_hat[0], log2_sigma...);
  }

 private:
  template <Arithmetic kArithmetic>
  void advance_by(int pieces, const LatentStep<Scalar, kNz, kNy>& step, const ForcedStep<Scalar, kNz, kNy>& forced_by,
                  Scalar (&z)[kNz], const Scalar (&y)[kNy], const Scalar (&y_next)[kNy], const Scalar (&u)[kNu],
                  const Scalar (&u_next)[kNu]) const {
    const Scalar share = Scalar(1) / static_cast<Scalar>(pieces);
    for (int i = 0; i < pieces; ++i) {
      const auto before = static_cast<Scalar>(i);
      const auto part = [&](Scalar c) { return rounded<Scalar>((before + c) * share); };
      Scalar from[kNy], half[kNy], to[kNy];
      between<kArithmetic>(latent.hold, y, y_next, part(Scalar(0)), from);
      between<kArithmetic>(latent.hold, y, y_next, part(Scalar(0.5)), half);
      between<kArithmetic>(latent.hold, y, y_next, part(Scalar(1)), to);
      exponential_rk_step<kPairs, kArithmetic>(
          step, forced_by, z, from, half, to, [&](Scalar c, const Scalar(&at)[kNz], Scalar(&dz)[kNz]) {
            Scalar y_now[kNy], u_now[kNu];
            between<kArithmetic>(latent.hold, y, y_next, part(c), y_now);
            // With the zero-order hold, the input given now has acted since the last sample.
            between<kArithmetic>(input_hold, input_hold == Hold::kZeroOrder ? u_next : u, u_next, part(c), u_now);
            drive<kArithmetic>(at, y_now, u_now, dz);
          });
    }
  }
};

/// The observer of a DrivenKklModel. The second parameter chooses the arithmetic, as for KklObserver.
template <class Model, Arithmetic kArithmetic = Arithmetic::kFast>
class DrivenKklObserver : public SampledObserver<Model, kArithmetic> {
 public:
  using SampledObserver<Model, kArithmetic>::SampledObserver;
};
template <class Model>
DrivenKklObserver(const Model&) -> DrivenKklObserver<Model>;

}  // namespace nlo::inline NLO_ISA
