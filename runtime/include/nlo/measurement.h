// SPDX-License-Identifier: MIT
// What measurements may be, and what is done with those that are not: a fault is held, a value out of range clamped, an
// angle continued from the last one. Whatever arrives, what an observer takes is finite.
#pragma once

#include <cstdint>

#include "nlo/arithmetic.h"
#include "nlo/select.h"
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

  /// The same, to the bit, in a number of instructions that does not depend on what was measured.
  constexpr StepStatus screen_evenly(const Vector<Scalar, kNy>& y, Scalar (&accepted)[kNy]) const {
    bool any_held = false, any_clamped = false;
    for (int j = 0; j < kNy; ++j) {
      const bool below = y[j]<min[j], above = y[j]> max[j];
      bool good = is_finite(y[j]);
      if (wrap[j] > Scalar(0)) {  // the model's choice, not the data's
        good = good & !below & !above;
        const Scalar change = select(good, y[j], accepted[j]) - accepted[j];
        const Scalar turns = whole_turns_evenly(change, wrap[j]);
        const Scalar next = accepted[j] + (change - rounded<Scalar>(wrap[j] * turns));
        accepted[j] = select(good, next, accepted[j]);
      } else {
        const Scalar in_range = select(below, min[j], select(above, max[j], y[j]));
        accepted[j] = select(good, in_range, accepted[j]);
        any_clamped = any_clamped | (good & (below | above));
      }
      any_held = any_held | !good;
    }
    return select(any_held, StepStatus::kHeld, select(any_clamped, StepStatus::kClamped, StepStatus::kOk));
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
  static constexpr Scalar whole_turns_evenly(Scalar angle, Scalar turn) {
    const Scalar turns = angle / turn;
    const bool none = (turns >= Scalar(-0.5)) & (turns <= Scalar(0.5));
    const Scalar half = select(turns < Scalar(0), Scalar(-0.5), Scalar(0.5));
    return select(none, Scalar(0), static_cast<Scalar>(static_cast<std::int32_t>(turns + half)));
  }
};

/// Counts one more measurement held in a row.
constexpr StepStatus note_held(std::uint16_t& held, std::uint16_t stale_after) {
  if (held < 0xffffU) ++held;
  return held >= stale_after ? StepStatus::kStale : StepStatus::kHeld;
}

/// Counts a screened measurement, held or not, in a number of instructions that does not depend on it.
constexpr StepStatus note_evenly(StepStatus screened, std::uint16_t& held, std::uint16_t stale_after) {
  const bool is_held = screened == StepStatus::kHeld;
  const auto one_more = static_cast<std::uint16_t>(held + (held < 0xffffU ? 1U : 0U));
  held = select(is_held, one_more, std::uint16_t{0});
  return select(is_held & (held >= stale_after), StepStatus::kStale, screened);
}

}  // namespace nlo
