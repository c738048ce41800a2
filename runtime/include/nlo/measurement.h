// SPDX-License-Identifier: MIT
// What measurements may be, and what becomes of those that are not: after a fault the last good value is held, a value
// out of range is clamped, an angle is continued from the last one. Whatever arrives, an observer takes a finite value.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/vector.h"

namespace nlo {

/// What became of a channel (an output or an input), the worse the larger: 0 it was used as it came, 1 it was clamped,
/// 1 + n it is held for the nth time in a row.
using Fate = std::uint16_t;
inline constexpr Fate kHeldOnce = 2;

template <Arithmetic kArithmetic>
constexpr Fate next_fate(Fate last, bool good, bool clamped) {
  const std::uint32_t held = last + 1U + static_cast<std::uint32_t>(last == 0);
  return select<kArithmetic>(good, static_cast<Fate>(clamped), static_cast<Fate>(held - (held >> 16U)));
}

template <Arithmetic kArithmetic>
constexpr Fate worse(Fate one, Fate other) {
  return select<kArithmetic>(one >= other, one, other);
}

/// A channel is stale, and with it the step, once it has been held `stale_after` times in a row.
template <Arithmetic kArithmetic>
constexpr StepStatus status_of(Fate fate, std::uint16_t stale_after) {
  const StepStatus held = select<kArithmetic>(fate <= stale_after, StepStatus::kHeld, StepStatus::kStale);
  return select<kArithmetic>(fate < kHeldOnce, static_cast<StepStatus>(fate & 1U), held);
}

template <class Scalar, int kNy>
struct ReadingRange {
  Scalar min[kNy];
  Scalar max[kNy];
  Scalar wrap[kNy];  ///< full turn of an angle (2 pi); 0: not an angle

  /// Writes the outputs to use into `accepted`, which holds the last good ones, and what became of each to `fate`; the
  /// worst of those. An angle comes out within half a turn of its last good value. All conditions are computed, none
  /// branched on: see arithmetic.h.
  template <Arithmetic kArithmetic>
  constexpr Fate screen(const Vector<Scalar, kNy>& y, Scalar (&accepted)[kNy], Fate* fate) const {
    Fate worst = 0;
    for (int j = 0; j < kNy; ++j) {
      const bool below = y[j] < min[j];
      const bool above = y[j] > max[j];
      bool good = is_finite(y[j]), clamped = false;
      // Each case selects for itself: a value common to both would move between register files in constant time.
      if (wrap[j] > Scalar(0)) {  // the model decides this branch, not the data
        good = good & !below & !above;
        const Scalar change = select<kArithmetic>(good, y[j], accepted[j]) - accepted[j];
        const Scalar next = accepted[j] + wrapped<kArithmetic>(change, wrap[j]);
        accepted[j] = select<kArithmetic>(good, next, accepted[j]);
      } else {
        clamped = below | above;
        const Scalar limit = select<kArithmetic>(below, min[j], max[j]);
        const Scalar within = select<kArithmetic>(!clamped, y[j], limit);
        accepted[j] = select<kArithmetic>(good, within, accepted[j]);
      }
      fate[j] = next_fate<kArithmetic>(fate[j], good, clamped);
      worst = j == 0 ? fate[j] : worse<kArithmetic>(worst, fate[j]);
    }
    return worst;
  }

  /// `y` is what screening can have left behind: in its range, or an angle within its first turn.
  constexpr bool may_hold(const Scalar (&y)[kNy]) const {
    bool good = true;
    for (int j = 0; j < kNy; ++j) {
      const bool in_range = (y[j] >= min[j]) & (y[j] <= max[j]);
      const bool in_turn = (y[j] >= -wrap[j]) & (y[j] <= wrap[j]);  // kept near zero, whatever range it is measured in
      good = good & is_finite(y[j]) & (in_range | ((wrap[j] > Scalar(0)) & in_turn));
    }
    return good;
  }

  /// The angle less its whole turns, in [-turn/2, turn/2].
  template <Arithmetic kArithmetic>
  NLO_SHARED_WITHOUT_FPU static constexpr Scalar wrapped(Scalar angle, Scalar turn) {
    return angle - rounded<Scalar>(turn * whole_turns<kArithmetic>(angle, turn));
  }

  /// angle / turn, rounded to an integer; 0 where an int32 cannot count them.
  template <Arithmetic kArithmetic>
  NLO_SHARED_WITHOUT_FPU static constexpr Scalar whole_turns(Scalar angle, Scalar turn) {
    // Within the declared range there are 2e5 at most. More come of a bit of memory that has flipped.
    const Scalar all = angle / turn;
    const Scalar turns = select<kArithmetic>(is_below(all, Scalar(0x1p30)), all, Scalar(0));
    // Half a turn counts as none: an angle resting on the wrap must not change sides, and z with it, at each step.
    const bool none = (turns >= Scalar(-0.5)) & (turns <= Scalar(0.5));
    const Scalar half = select<kArithmetic>(turns < Scalar(0), Scalar(-0.5), Scalar(0.5));
    return select<kArithmetic>(none, Scalar(0), static_cast<Scalar>(static_cast<std::int32_t>(turns + half)));
  }
};
template <class Scalar, int kNy>
using OutputRange [[deprecated("it is called ReadingRange")]] = ReadingRange<Scalar, kNy>;

/// Outputs that may be missing (sensor_failures.h), which none may unless a model says so.
template <class Scalar, int kNf>
struct SensorFailures;
template <class Scalar>
struct SensorFailures<Scalar, 0> {};

/// The inputs of the last sample where they act apart from the readings (acting_inputs.h); else nothing.
template <class Scalar, int kNu>
struct InputMemory;
template <class Scalar>
struct InputMemory<Scalar, 0> {
  constexpr bool is_reachable() const { return true; }
};

}  // namespace nlo
