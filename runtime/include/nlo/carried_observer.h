// SPDX-License-Identifier: MIT
// The carried observer: a KKL observer (16) of vectors in the axes of a rotating body, such as gravity. A gyroscope
// measures the angular rate w (three inputs). A vector x that is constant in the world obeys x' = -w x x in the axes of
// the body. The latent states rotate likewise, three rows for each mode of D:
//   z' = D z + F y - w x z,   x_hat = sum_k c_k z_k   (scaled to unit length if the model says so)
// In axes that do not rotate this is the linear system z' = D z + F y. Therefore the errors decay with the eigenvalues
// of D for every w. If the sensor's axes are rotated, z and x_hat rotate with them, to rounding.
//
//   observer.step({{ax, ay, az}}, {{wx, wy, wz}});   // w in rad/s, of the axes that y is measured in
//
// A step rotates z and the last y (rotation.h). Then it steps D and F exactly (latent.h), with y on a ramp from the
// rotated last y to the next one.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kkl_observer.h"
#include "nlo/latent.h"
#include "nlo/measurement.h"
#include "nlo/observer_state.h"
#include "nlo/rotation.h"
#include "nlo/sampled_observer.h"

namespace nlo::inline NLO_ISA {

/// Limits within which a rotation takes a fixed number of operations. Export refuses a range of w that turns by more
/// than kMostTurn [rad] in a sample period. Therefore theta, with its coning term, is below 2^3 in a sample period and
/// below 2^21 in the longest gap.
struct CarriedLimits {
  static constexpr double kMostTurn = 4.0;
  static constexpr int kLongestGap = 1000, kUsualDoublings = 3, kMostDoublings = 21;
};

/// The constants of an observer. A generated header defines them: `inline constexpr Model kModel`.
/// Outputs and states are vectors of three components, one after another. z has kModes rows for the first component of
/// the first output vector, then kModes rows for its second component, and so on.
template <class Scalar_, int kNx_, int kNy_, int kModes_, int kPairs_, bool kReadsOutput_, bool kUnitLength_,
          Hold kInputHold_ = Hold::kZeroOrder>
struct CarriedModel {
  using Scalar = Scalar_;
  static constexpr int kNx = kNx_;
  static constexpr int kNy = kNy_;
  static constexpr int kModes = kModes_;  ///< rows of D for one component
  static constexpr int kPairs = kPairs_;  ///< number of complex pairs among these rows
  static constexpr int kNz = kNy * kModes;
  static constexpr int kNu = 3;  ///< w
  static constexpr int kNf = 0;
  static constexpr int kNr = kNy + kNu;
  static constexpr Hold kInputHold = kInputHold_;
  static constexpr bool kReadsOutput = kReadsOutput_;  ///< x_hat combines z and the latest y, not z alone
  static constexpr bool kUnitLength = kUnitLength_;
  static constexpr int kLongestGap = CarriedLimits::kLongestGap;
  static constexpr bool kHasSteadyState = false;  ///< z keeps rotating with w
  static constexpr bool kMayDiverge = false;
  static constexpr int kFeatures = kNy / 3 * (kModes + (kReadsOutput ? 1 : 0));  ///< vectors that x_hat combines
  static_assert(kNx > 0 && kNy > 0 && kNx % 3 == 0 && kNy % 3 == 0, "states and outputs are vectors of three");
  static_assert(kModes > 0 && kPairs >= 0 && 2 * kPairs <= kModes);

  Scalar sample_period_s;
  std::uint16_t stale_after;              ///< after this many held measurements in a row the status is kStale
  LatentModel<Scalar, kModes, 1> latent;  ///< latent system of one component
  ReadingRange<Scalar, kNr> outputs;      ///< ranges of y and w
  Domain<Scalar, kNz> domain;
  Scalar weights[kNx / 3][kFeatures];  ///< c: weights of the modes of each output vector, followed by that of y

  constexpr const Scalar (&initial_latent() const)[kNz] { return kZero; }

  /// Sets z at the first measurement. If the model starts steady, z is the steady state of that measurement.
  template <Arithmetic = Arithmetic::kFast>
  constexpr void start(const Scalar (&y)[kNr], Scalar (&z)[kNz]) const {
    for (int r = 0; latent.starts_steady && r < kNz; ++r) z[r] = latent.steady_gain[r % kModes][0] * y[r / kModes];
  }

  /// Advances z over dt_s seconds; 0: one sample period.
  template <Arithmetic kArithmetic = Arithmetic::kFast>
  constexpr void advance(Scalar (&z)[kNz], const Scalar (&y)[kNr], const Scalar (&y_next)[kNr], Scalar dt_s) const {
    if (dt_s == Scalar(0))
      return advance_by<kArithmetic, CarriedLimits::kUsualDoublings>(latent.step, sample_period_s, z, y, y_next);
    advance_by<kArithmetic, CarriedLimits::kMostDoublings>(
        discretise<kPairs>(latent.exact_hold(), latent.eigenvalues, latent.output_injection, dt_s), dt_s, z, y, y_next);
  }

  template <Arithmetic kArithmetic = Arithmetic::kFast>
  constexpr void estimate(const Scalar (&z)[kNz], const Scalar (&y)[kNr], Scalar (&x_hat)[kNx]) const {
    for (int s = 0; s < kNx; s += 3) {
      Scalar sum[3]{};
      for (int f = 0; f < kFeatures; ++f) {
        const int row = f < kNy / 3 * kModes ? f / kModes * 3 * kModes + f % kModes : 0;
        for (int c = 0; c < 3; ++c) {
          const Scalar value = f < kNy / 3 * kModes ? z[row + c * kModes] : y[3 * f - kNz + c];
          sum[c] = multiply_add<kArithmetic>(weights[s / 3][f], value, sum[c]);
        }
      }
      if constexpr (kUnitLength) make_unit<kArithmetic>(sum);
      for (int c = 0; c < 3; ++c) x_hat[s + c] = sum[c];
    }
  }

 private:
  static constexpr Scalar kZero[kNz]{};

  template <Arithmetic kArithmetic, int kDoublings>
  constexpr void advance_by(const LatentStep<Scalar, kModes, 1>& step, Scalar h, Scalar (&z)[kNz],
                            const Scalar (&y)[kNr], const Scalar (&y_next)[kNr]) const {
    Scalar w[3]{}, w_next[3]{}, theta[3]{};
    for (int c = 0; c < 3; ++c) {
      w[c] = y[kNy + c];
      w_next[c] = y_next[kNy + c];
    }
    rotation_vector(w, w_next, h, theta);
    const Rotation<Scalar> rotation = Rotation<Scalar>::template of<kDoublings>(theta);
    for (int j = 0; j < kNy; j += 3) {
      Scalar turned[3][kModes]{};
      for (int m = 0; m < kModes; ++m) {
        Scalar vector[3] = {z[j * kModes + m], z[(j + 1) * kModes + m], z[(j + 2) * kModes + m]};
        rotation.template turn<kArithmetic>(vector);
        for (int c = 0; c < 3; ++c) turned[c][m] = vector[c];
      }
      Scalar last[3] = {y[j], y[j + 1], y[j + 2]};
      rotation.template turn<kArithmetic>(last);
      for (int c = 0; c < 3; ++c) {
        const Scalar from[1] = {last[c]}, to[1] = {y_next[j + c]};
        nlo::advance<kPairs, kArithmetic>(step, turned[c], from, to);
        for (int m = 0; m < kModes; ++m) z[(j + c) * kModes + m] = turned[c][m];
      }
    }
  }
};

/// The observer of a CarriedModel. The second parameter chooses the arithmetic, as for KklObserver.
template <class Model, Arithmetic kArithmetic = Arithmetic::kFast>
class CarriedObserver : public SampledObserver<Model, kArithmetic> {
 public:
  using SampledObserver<Model, kArithmetic>::SampledObserver;
};
template <class Model>
CarriedObserver(const Model&) -> CarriedObserver<Model>;

}  // namespace nlo::inline NLO_ISA
