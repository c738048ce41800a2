// SPDX-License-Identifier: MIT
// Inputs that act apart from the readings, as an observer remembers them. A model that has some includes this
// (driven_kkl_observer.h does).
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/measurement.h"
#include "nlo/vector.h"

namespace nlo {

template <class Scalar, int kNu>
struct InputMemory {
  Scalar u[kNu];

  /// Takes the inputs that are finite, and holds the others. As screen() of ReadingRange.
  template <Arithmetic kArithmetic>
  constexpr Fate take(const Vector<Scalar, kNu>& given, Fate* fate) {
    Fate worst = 0;
    for (int i = 0; i < kNu; ++i) {
      const bool good = is_finite(given[i]);
      u[i] = select<kArithmetic>(good, given[i], u[i]);
      fate[i] = next_fate<kArithmetic>(fate[i], good, false);
      worst = worse<kArithmetic>(worst, fate[i]);
    }
    return worst;
  }

  constexpr bool is_reachable() const {
    for (const Scalar value : u) {
      if (!is_finite(value)) return false;
    }
    return true;
  }
};

}  // namespace nlo
