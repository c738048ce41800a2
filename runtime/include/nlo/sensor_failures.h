// SPDX-License-Identifier: MIT
// Outputs that are declared as may_fail. Such an output may be missing for any time. While it is missing, its value
// decays from the last good one to its mean in training. T* reads its staleness s beside the other readings:
//   missing    y <- rest + k (y - rest),  s <- 1 - k (1 - s)
//   measured                              s <- k s              k = exp(-dt / staleness_s)
// A slow output (measurement.h) is not missing between its samples: it holds its last value. It is missing once it is
// late by half its period.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/latent.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// kNf: number of outputs that may be missing.
template <class Scalar, int kNf>
struct SensorFailures {
  int output[kNf];   ///< their indices
  Scalar rest[kNf];  ///< their mean in training
  Scalar rate;       ///< 1 / staleness_s
  Scalar keep;       ///< k for dt = one sample period

  /// Returns k for dt = dt_s seconds.
  constexpr Scalar keep_over(Scalar dt_s) const { return decay_minus_1(rounded<Scalar>(rate * dt_s)) + Scalar(1); }

  /// Replaces missing outputs and writes the stalenesses, which are the last kNf readings. Returns which outputs were
  /// missing.
  ///   last  the readings of the last sample
  ///   k     k over the time of the step; 0 in the first sample
  template <Arithmetic kArithmetic, int kNr>
  constexpr Vector<bool, kNf> fill(Vector<Scalar, kNr>& readings, const Scalar (&last)[kNr], Scalar k) const {
    Vector<bool, kNf> missing{};
    for (int i = 0; i < kNf; ++i) {
      Scalar& y = readings[output[i]];
      const bool measured = is_finite(y);
      const Scalar fading = rest[i] + rounded<Scalar>(k * (last[output[i]] - rest[i]));
      y = select<kArithmetic>(measured, y, fading);
      const Scalar kept = rounded<Scalar>(k * last[kNr - kNf + i]);
      const Scalar staler = Scalar(1) - rounded<Scalar>(k * (Scalar(1) - last[kNr - kNf + i]));
      readings[kNr - kNf + i] = select<kArithmetic>(measured, kept, staler);
      missing[i] = !measured;
    }
    return missing;
  }
};
template <class Scalar>
struct SensorFailures<Scalar, 0> {};

}  // namespace nlo::inline NLO_ISA
