// SPDX-License-Identifier: MIT
// A learned T* says nothing of places where training has not been. Of a model that saturates it reads z no further than
// a margin beyond the domain, so that whatever z does, the estimate stays one that T* gives at the edge:
//   x_hat = T*(sat(z), y),              sat(z) = z, held within [min, max] in each coordinate
//   x_hat = T*(S y + sat(z - S y), y)   for outputs that T* knows relative to their steady state S y, angles among them
// Continuous, and z itself, bit for bit, within the box.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/kkl_observer.h"

namespace nlo {

/// The box [min, max]: the domain and the margin.
template <class Scalar, int kNz, int kNr, Saturation kSaturation>
struct LatentReach {
  Scalar min[kNz];
  Scalar max[kNz];
};
template <class Scalar, int kNz, int kNr>
struct LatentReach<Scalar, kNz, kNr, Saturation::kRelativeLatent> {
  Scalar min[kNz];
  Scalar max[kNz];
  Scalar steady_gain[kNr][kNz];  ///< columns of S, zeros for what is not relative: vectors of z
};

/// kLanes coordinates of z from r on, as T* reads them.
template <Arithmetic kArithmetic, int kLanes, class Model, class Scalar, int kNz, int kNr>
NLO_INLINE simd::Pack<Scalar, kLanes> saturated_at(const Model& model, const Scalar (&y)[kNr], const Scalar (&z)[kNz],
                                                   int r) {
  using P = simd::Pack<Scalar, kLanes>;
  const auto held = [&](P place) NLO_INLINE_LAMBDA {
    return simd::smaller(simd::larger(place, simd::load<P>(&model.reach.min[r])), simd::load<P>(&model.reach.max[r]));
  };
  const P all = simd::load<P>(&z[r]);
  if constexpr (Model::kSaturation == Saturation::kLatent) return held(all);
  P rest{};
  if constexpr (Model::kSaturation == Saturation::kRelativeLatent) {
    for (int j = 0; j < kNr; ++j) {
      rest += rounded<P>(simd::load<P>(&model.reach.steady_gain[j][r]) * y[j]);
    }
  }
  const P place = all - rest, within = held(place);
  if constexpr (kLanes == 1) {
    return select<kArithmetic>(place == within, all, rest + within);
  } else {
    return place == within ? all : rest + within;
  }
}

/// z as T* reads it.
template <Arithmetic kArithmetic, class Model, class Scalar, int kNz, int kNr>
void saturate(const Model& model, const Scalar (&y)[kNr], const Scalar (&z)[kNz], Scalar (&saturated)[kNz]) {
  constexpr int kLanes = simd::kLanes<Scalar>;
  if constexpr (kNz < kLanes) {
    for (int r = 0; r < kNz; ++r) saturated[r] = saturated_at<kArithmetic, 1>(model, y, z, r);
  } else {
    for (int r = 0; r + kLanes <= kNz; r += kLanes) {
      simd::store(&saturated[r], saturated_at<kArithmetic, kLanes>(model, y, z, r));
    }
    // What is left ends in a whole vector too, some of which has been done.
    if constexpr (kNz % kLanes != 0) {
      simd::store(&saturated[kNz - kLanes], saturated_at<kArithmetic, kLanes>(model, y, z, kNz - kLanes));
    }
  }
}

}  // namespace nlo
