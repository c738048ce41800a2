// SPDX-License-Identifier: MIT
// Sum of the lanes of a vector.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"

namespace nlo::inline NLO_ISA::simd {

/// Returns the sum of the lanes, added pairwise.
template <class Scalar, class P>
NLO_INLINE Scalar sum(P value) {
  constexpr int kN = sizeof(P) / sizeof(Scalar);
  if constexpr (kN == 1) {
    return value;
  } else {
    Scalar lanes[kN];
    store(lanes, value);
    for (int half = kN / 2; half > 0; half /= 2) {
      for (int i = 0; i < half; ++i) lanes[i] += lanes[i + half];
    }
    return lanes[0];
  }
}

}  // namespace nlo::inline NLO_ISA::simd
