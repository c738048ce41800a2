// SPDX-License-Identifier: MIT
// What measurements may be, and what becomes of those that are not: after a fault the last good value is held, a value
// out of range is clamped, an angle is continued from the last one. Whatever arrives, an observer takes a finite value.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/vector.h"

namespace nlo {

template <class Scalar, int kNy>
struct OutputRange {
  Scalar min[kNy];
  Scalar max[kNy];
  Scalar wrap[kNy];  ///< full turn of an angle (2 pi); 0: not an angle

  /// Writes the outputs to use into `accepted`, which holds the last good ones. An angle comes out within half a turn
  /// of its last good value. All conditions are computed, none branched on: see arithmetic.h.
  template <Arithmetic kArithmetic>
  constexpr StepStatus screen(const Vector<Scalar, kNy>& y, Scalar (&accepted)[kNy]) const {
    bool any_held = false, any_clamped = false;
    for (int j = 0; j < kNy; ++j) {
      const bool below = y[j] < min[j];
      const bool above = y[j] > max[j];
      bool good = is_finite(y[j]);
      // Each case selects for itself: a value common to both would move between register files in constant time.
      if (wrap[j] > Scalar(0)) {  // the model decides this branch, not the data
        good = good & !below & !above;
        const Scalar change = select<kArithmetic>(good, y[j], accepted[j]) - accepted[j];
        const Scalar next = accepted[j] + wrapped<kArithmetic>(change, wrap[j]);
        accepted[j] = select<kArithmetic>(good, next, accepted[j]);
      } else {
        any_clamped = any_clamped | (good & (below | above));
        const Scalar limit = select<kArithmetic>(below, min[j], max[j]);
        const Scalar clamped = select<kArithmetic>(!(below | above), y[j], limit);
        accepted[j] = select<kArithmetic>(good, clamped, accepted[j]);
      }
      any_held = any_held | !good;
    }
    const StepStatus used = select<kArithmetic>(!any_clamped, StepStatus::kOk, StepStatus::kClamped);
    return select<kArithmetic>(!any_held, used, StepStatus::kHeld);
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
  static constexpr Scalar wrapped(Scalar angle, Scalar turn) {
    return angle - rounded<Scalar>(turn * whole_turns<kArithmetic>(angle, turn));
  }

  /// angle / turn, rounded to an integer; 0 where an int32 cannot count them.
  template <Arithmetic kArithmetic>
  static constexpr Scalar whole_turns(Scalar angle, Scalar turn) {
    // Within the declared range there are 2e5 at most. More come of a bit of memory that has flipped.
    const Scalar all = angle / turn;
    const Scalar turns = select<kArithmetic>(is_below(all, Scalar(0x1p30)), all, Scalar(0));
    // Half a turn counts as none: an angle resting on the wrap must not change sides, and z with it, at each step.
    const bool none = (turns >= Scalar(-0.5)) & (turns <= Scalar(0.5));
    const Scalar half = select<kArithmetic>(turns < Scalar(0), Scalar(-0.5), Scalar(0.5));
    return select<kArithmetic>(none, Scalar(0), static_cast<Scalar>(static_cast<std::int32_t>(turns + half)));
  }
};

/// Outputs that may be missing (sensor_failures.h), which none may unless a model says so.
template <class Scalar, int kNf>
struct SensorFailures;
template <class Scalar>
struct SensorFailures<Scalar, 0> {};

/// The inputs of the last sample where they act apart from the readings (driven_kkl_observer.h); else nothing.
template <class Scalar, int kNu>
struct InputMemory {
  Scalar u[kNu];

  /// Takes the inputs that are finite, and holds the others. False: one of them was held.
  constexpr bool take(const Vector<Scalar, kNu>& given) {
    bool all_finite = true;
    for (int i = 0; i < kNu; ++i) {
      if (is_finite(given[i])) {
        u[i] = given[i];
      } else {
        all_finite = false;
      }
    }
    return all_finite;
  }
};
template <class Scalar>
struct InputMemory<Scalar, 0> {
  constexpr bool take(const Vector<Scalar, 1>&) { return true; }
};

/// The status of a sample of which an output is missing that may be: held, and no step towards stale.
template <Arithmetic kArithmetic>
constexpr StepStatus noted(bool missing, StepStatus screened) {
  return select<kArithmetic>(!(missing & (screened < StepStatus::kHeld)), screened, StepStatus::kHeld);
}

/// Counts how many measurements in a row were held, this one included; its status, which is kStale after too many.
template <Arithmetic kArithmetic>
constexpr StepStatus count_held(StepStatus screened, std::uint16_t& held, std::uint16_t stale_after) {
  const bool good = screened != StepStatus::kHeld;
  const auto one_more = static_cast<std::uint16_t>(held + (held < 0xffffU ? 1U : 0U));
  held = select<kArithmetic>(good, std::uint16_t{0}, one_more);
  return select<kArithmetic>(good | (held < stale_after), screened, StepStatus::kStale);
}

}  // namespace nlo
