// SPDX-License-Identifier: MIT
// What measurements may be, and what is done with those that are not: a fault is held, a value out of range clamped, an
// angle continued from the last one. Whatever arrives, what an observer takes is finite.
#pragma once

#include <cstdint>

#include "nlo/arithmetic.h"
#include "nlo/simd.h"
#include "nlo/vector.h"

namespace nlo {

template <class Scalar, int kNy>
struct OutputRange {
  Scalar min[kNy];
  Scalar max[kNy];
  Scalar wrap[kNy];  ///< full turn of an angle (2 pi); 0: not an angle

  /// Writes the outputs to use into `accepted`, which holds the last good ones. Angles come out next to those.
  constexpr StepStatus screen(const Vector<Scalar, kNy>& y, Scalar (&accepted)[kNy]) const {
    StepStatus status = StepStatus::kOk;
    for (int j = 0; j < kNy; ++j) {
      const bool angle = wrap[j] > Scalar(0);
      if (!is_finite(y[j]) || (angle && (y[j] < min[j] || y[j] > max[j]))) {
        status = StepStatus::kHeld;
      } else if (angle) {
        accepted[j] += wrapped(y[j] - accepted[j], wrap[j]);
      } else if (y[j] < min[j] || y[j] > max[j]) {
        accepted[j] = y[j] < min[j] ? min[j] : max[j];
        if (status == StepStatus::kOk) status = StepStatus::kClamped;
      } else {
        accepted[j] = y[j];
      }
    }
    return status;
  }

  /// `y` is what screening can have left behind: in its range, or an angle within its first turn.
  constexpr bool may_hold(const Scalar (&y)[kNy]) const {
    bool good = true;
    for (int j = 0; j < kNy; ++j) {
      const bool in_range = y[j] >= min[j] && y[j] <= max[j];
      const bool in_turn = y[j] >= -wrap[j] && y[j] <= wrap[j];  // kept near zero, whatever range it is measured in
      good = good && is_finite(y[j]) && (in_range || (wrap[j] > Scalar(0) && in_turn));
    }
    return good;
  }

  /// The angle less its whole turns, in [-turn/2, turn/2].
  static constexpr Scalar wrapped(Scalar angle, Scalar turn) {
    return angle - rounded<Scalar>(turn * whole_turns(angle, turn));
  }
  static constexpr Scalar whole_turns(Scalar angle, Scalar turn) {
    const Scalar turns = angle / turn;  // bounded by the declared range: fits an int32
    // Half a turn stays where it is: an angle resting on the wrap must not change sides, and z with it, at each step.
    if (turns >= Scalar(-0.5) && turns <= Scalar(0.5)) return Scalar(0);
    return static_cast<Scalar>(static_cast<std::int32_t>(turns + (turns < Scalar(0) ? Scalar(-0.5) : Scalar(0.5))));
  }
};

/// Counts one more measurement held in a row.
constexpr StepStatus note_held(std::uint16_t& held, std::uint16_t stale_after) {
  if (held < 0xffffU) ++held;
  return held >= stale_after ? StepStatus::kStale : StepStatus::kHeld;
}

}  // namespace nlo
