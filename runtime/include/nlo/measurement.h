// SPDX-License-Identifier: MIT
// Validation of measurements. A value that is not finite is replaced by the last good one, a value out of its range is
// clamped, an angle is continued from the last one. So an observer takes a finite value, whatever arrives.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/vector.h"

namespace nlo {

/// Health of one channel, an output or an input. 0: its latest sample was used unchanged. Otherwise bits 2 to 15 count
/// the samples in a row that were not used unchanged, and bits 0 and 1 say what happened last:
///   kHeldBit                the last good value was used instead
///   kClampedBit             the sample was clamped to the range of the channel
///   kClampedBit | kHeldBit  samples were missed before it (a step over a gap), and it was clamped
///   neither bit             samples were missed before it, and it was used unchanged: the next count starts at 1
using ChannelHealth = std::uint16_t;
inline constexpr ChannelHealth kHeldBit = 1;
inline constexpr ChannelHealth kClampedBit = 2;
inline constexpr std::uint32_t kMostCounted = 0x3fff;  ///< samples; the counter stays there
inline constexpr ChannelHealth kHeldOnce = 1U << 2U | kHeldBit;

/// The health after `samples` more that were not used unchanged, with these bits.
constexpr ChannelHealth counted_on(ChannelHealth last, std::uint32_t samples, std::uint32_t bits) {
  const std::uint32_t before = (last >> 2U) & (0U - static_cast<std::uint32_t>((last & 3U) != 0));
  const std::uint32_t all = before + samples, beyond = all > kMostCounted;
  return static_cast<ChannelHealth>((all - beyond * (all - kMostCounted)) << 2U | bits);
}

/// The health after a sample. good: it was not held. clamped: it was, which a good one may be.
template <Arithmetic kArithmetic>
constexpr ChannelHealth next_health(ChannelHealth last, bool good, bool clamped) {
  const ChannelHealth worse = counted_on(last, 1, 1U + static_cast<std::uint32_t>(good));
  return select<kArithmetic>(good & !clamped, ChannelHealth{0}, worse);
}

/// The health before a sample that `missed` samples should have preceded.
constexpr ChannelHealth health_after_missed(ChannelHealth last, int missed) {
  return missed == 0 ? last : counted_on(last, static_cast<std::uint32_t>(missed), kHeldBit);
}

/// The health after that sample. missed: health_after_missed(); next: next_health() of it.
constexpr ChannelHealth health_after_gap(ChannelHealth missed, ChannelHealth next) {
  if (next == 0) return static_cast<ChannelHealth>(missed & ~3U);
  return static_cast<ChannelHealth>(next | kHeldBit);
}

/// How many samples a step over dt_s seconds has missed. Up to 1.5 sample periods are jitter.
template <class Scalar>
constexpr int missed_samples(Scalar dt_s, Scalar sample_period_s) {
  const Scalar periods = dt_s / sample_period_s;
  return periods > Scalar(1.5) ? static_cast<int>(periods + Scalar(0.5)) - 1 : 0;
}

/// Status of one channel. After `stale_after` samples in a row that were not used unchanged, the estimate is not to be
/// trusted.
template <Arithmetic kArithmetic>
constexpr StepStatus status_of(ChannelHealth health, std::uint16_t stale_after) {
  const std::uint32_t limit = stale_after < kMostCounted ? stale_after : kMostCounted;
  const std::uint32_t bad = health != 0, clamped = health >> 1U & 1U, late = bad & ((health >> 2U) >= limit);
  const auto early = static_cast<StepStatus>(bad + (bad & ((health & 3U) != kClampedBit)));  // kOk, kClamped, kHeld
  return select<kArithmetic>(late == 0, early, static_cast<StepStatus>(3U + clamped));       // kStale, kOutOfRange
}
static_assert(static_cast<int>(StepStatus::kClamped) == 1 && static_cast<int>(StepStatus::kHeld) == 2 &&
              static_cast<int>(StepStatus::kStale) == 3 && static_cast<int>(StepStatus::kOutOfRange) == 4);

template <Arithmetic kArithmetic>
constexpr StepStatus worse(StepStatus one, StepStatus other) {
  return select<kArithmetic>(one >= other, one, other);
}

template <class Scalar, int kNy>
struct ReadingRange {
  Scalar min[kNy];
  Scalar max[kNy];
  Scalar wrap[kNy];  ///< full turn of an angle (2 pi), or of an output that T* knows only relatively; 0: it is clamped

  /// Validates the readings of a sample: overwrites `accepted`, which holds the last good ones, with the usable values,
  /// and updates the health of each channel. Returns true if one of them was held. A value that wraps comes
  /// out within half a turn of its last good one. All conditions are computed, none branched on: see arithmetic.h.
  template <Arithmetic kArithmetic>
  constexpr bool validate(const Vector<Scalar, kNy>& y, Scalar (&accepted)[kNy], ChannelHealth* health) const {
    bool held = false;
    for (int j = 0; j < kNy; ++j) {
      const bool below = y[j] < min[j];
      const bool above = y[j] > max[j];
      bool good = is_finite(y[j]), clamped = false;
      // Each case selects for itself: a value common to both would move between register files in constant time.
      if (wrap[j] > Scalar(0)) {  // the model decides this branch, not the data
        good = good & !below & !above;
        // Within half a turn of the last one y is used bit for bit; if the turn is a power of two, whole turns go
        // exactly.
        const Scalar from = select<kArithmetic>(good, y[j], accepted[j]);
        const Scalar turns = whole_turns<kArithmetic>(from - accepted[j], wrap[j]);
        accepted[j] = from - rounded<Scalar>(wrap[j] * turns);
      } else {
        clamped = good & (below | above);
        const Scalar limit = select<kArithmetic>(below, min[j], max[j]);
        const Scalar within = select<kArithmetic>(!clamped, y[j], limit);
        accepted[j] = select<kArithmetic>(good, within, accepted[j]);
      }
      health[j] = next_health<kArithmetic>(health[j], good, clamped);
      held |= !good;
    }
    return held;
  }

  /// `y` is a value that validation can have stored: in its range, or within its first turn.
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
    // Without the division: turn / 2 is exact, and |angle / turn| is at most 1/2 just where |angle| is at most that.
    if constexpr (!kConstantTime<kArithmetic>) {
      const Scalar half_turn = turn * Scalar(0.5);
      if (angle >= -half_turn && angle <= half_turn) [[likely]]
        return Scalar(0);
    }
    // Validation lets 2^17 pass at most. More come of a bit flip.
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

}  // namespace nlo
