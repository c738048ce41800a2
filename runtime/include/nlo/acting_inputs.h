// SPDX-License-Identifier: MIT
// Inputs that act apart from the readings (driven_kkl_observer.h), as an observer remembers them.
#pragma once

#include "nlo/kernels/arithmetic.h"
#include "nlo/measurement.h"
#include "nlo/vector.h"

namespace nlo {

/// The inputs of the last sample; nothing where none act apart from the readings.
template <class Scalar, int kNu>
struct InputMemory {
  Scalar u[kNu];

  /// Takes the inputs that are finite and holds the others. As validate() of ReadingRange; these have no range.
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

}  // namespace nlo
