// SPDX-License-Identifier: MIT
// The known inputs of a driven observer (driven_kkl_observer.h), stored apart: its F and T* do not read them.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/measurement.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

/// The inputs of the latest sample. Empty (kNu = 0) for every other kind of observer.
template <class Scalar, int kNu>
struct InputMemory {
  Scalar u[kNu];

  /// Validates inputs: stores the finite ones, holds the last good value of the others, and updates the health of each.
  /// Returns true if one was held. Unlike readings (ReadingRange) these inputs have no range.
  template <Arithmetic kArithmetic>
  constexpr bool validate(const Vector<Scalar, kNu>& given, ChannelHealth* health) {
    bool held = false;
    for (int i = 0; i < kNu; ++i) {
      const bool good = is_finite(given[i]);
      u[i] = select<kArithmetic>(good, given[i], u[i]);
      health[i] = next_health<kArithmetic>(health[i], good, false);
      held |= !good;
    }
    return held;
  }

  constexpr bool is_reachable() const {
    for (const Scalar value : u) {
      if (!is_finite(value)) return false;
    }
    return true;
  }
};
template <class Scalar>
struct InputMemory<Scalar, 0> {
  constexpr bool is_reachable() const { return true; }
};

}  // namespace nlo::inline NLO_ISA
