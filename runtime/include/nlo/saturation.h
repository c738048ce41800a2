// SPDX-License-Identifier: MIT
// Saturation: limits the z that T* reads to a box, the domain of the training and a margin around it. Far from its
// training data, a learned T* is arbitrary. With saturation the estimate stays near its value at the edge of the box.
//   x_hat = T*(sat(z), y),              sat(z) = z limited to [min, max] in each coordinate
//   x_hat = T*(S y + sat(z - S y), y)
//                                       for outputs that T* reads only through z - S y, such as angles
// sat is continuous. Inside the box it returns z, bit for bit.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/kkl_observer.h"

namespace nlo::inline NLO_ISA {

/// The box [min, max]: the domain and a margin.
template <class Scalar, int kNz, int kNr, Saturation kSaturation>
struct LatentReach {
  Scalar min[kNz];
  Scalar max[kNz];
};
template <class Scalar, int kNz, int kNr>
struct LatentReach<Scalar, kNz, kNr, Saturation::kRelativeLatent> {
  Scalar min[kNz];
  Scalar max[kNz];
  Scalar steady_gain[kNr][kNz];  ///< S transposed; zero for readings that are not relative
};

/// Saturates coordinates r to r + kLanes - 1 of z.
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

/// saturated = sat(z), or S y + sat(z - S y).
template <Arithmetic kArithmetic, class Model, class Scalar, int kNz, int kNr>
void saturate(const Model& model, const Scalar (&y)[kNr], const Scalar (&z)[kNz], Scalar (&saturated)[kNz]) {
  constexpr int kLanes = simd::kLanes<Scalar>;
  if constexpr (kNz < kLanes) {
    for (int r = 0; r < kNz; ++r) saturated[r] = saturated_at<kArithmetic, 1>(model, y, z, r);
  } else {
    for (int r = 0; r + kLanes <= kNz; r += kLanes) {
      simd::store(&saturated[r], saturated_at<kArithmetic, kLanes>(model, y, z, r));
    }
    // The last vector overlaps the one before it, so that the rest needs no scalar loop.
    if constexpr (kNz % kLanes != 0) {
      simd::store(&saturated[kNz - kLanes], saturated_at<kArithmetic, kLanes>(model, y, z, kNz - kLanes));
    }
  }
}

}  // namespace nlo::inline NLO_ISA
