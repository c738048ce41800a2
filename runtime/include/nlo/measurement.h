// SPDX-License-Identifier: MIT
// Validation of measurements. A value that is not finite is replaced by the last good one. A value out of range is
// clamped. An angle is unwrapped: it continues from the last one without jumps. The result is always finite.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"
#include "nlo/vector.h"

namespace nlo::inline NLO_ISA {

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

/// Returns the health after `samples` further samples that were not used unchanged. `bits`: the new bits 0 and 1.
constexpr ChannelHealth counted_on(ChannelHealth last, std::uint32_t samples, std::uint32_t bits) {
  const std::uint32_t before = (last >> 2U) & (0U - static_cast<std::uint32_t>((last & 3U) != 0));
  const std::uint32_t all = before + samples, beyond = all > kMostCounted;
  return static_cast<ChannelHealth>((all - beyond * (all - kMostCounted)) << 2U | bits);
}

/// Returns the health after a sample. good: its value was used, unchanged or clamped. clamped: its value was clamped.
template <Arithmetic kArithmetic>
constexpr ChannelHealth next_health(ChannelHealth last, bool good, bool clamped) {
  const ChannelHealth worse = counted_on(last, 1, 1U + static_cast<std::uint32_t>(good));
  return select<kArithmetic>(good & !clamped, ChannelHealth{0}, worse);
}

/// Returns the health after `missed` samples that did not arrive. kept_bits: kClampedBit for a slow output, else 0.
constexpr ChannelHealth health_after_missed(ChannelHealth last, int missed, std::uint32_t kept_bits = 0) {
  return missed == 0 ? last : counted_on(last, static_cast<std::uint32_t>(missed), kHeldBit | (last & kept_bits));
}

/// Returns the health after the first sample behind a gap.
///   missed  health_after_missed() of the gap
///   next    next_health() of `missed` after that sample
constexpr ChannelHealth health_after_gap(ChannelHealth missed, ChannelHealth next) {
  if (next == 0) return static_cast<ChannelHealth>(missed & ~3U);
  return static_cast<ChannelHealth>(next | kHeldBit);
}

/// Returns the number of samples after an arrival in which reading j is not due; 0: it is due in every sample. A model
/// with slower outputs has kNotDue, a number per reading: 19 for an output of 5 Hz in an observer of 100 Hz.
template <class Model>
constexpr std::uint32_t not_due([[maybe_unused]] int j) {
  if constexpr (requires { Model::kNotDue[0]; }) return Model::kNotDue[j];
  return 0;
}
template <class Model>
inline constexpr bool kHasSlowOutputs = requires {
  Model::kNotDue[0];
};

/// Returns the largest number of samples in a row that a slow output may be missing: it may be late by half its period.
constexpr std::uint32_t most_missing(std::uint32_t not_due) {
  return not_due + (not_due + 1) / 2;
}

/// Returns the health of a slow output that has never arrived.
constexpr ChannelHealth never_arrived(std::uint32_t not_due) {
  return static_cast<ChannelHealth>((most_missing(not_due) + 1) << 2U | kHeldBit);
}

/// Returns the health of a slow output for its status. While no sample is due, it is 0. If the output is late by more
/// than half its period, it counts the samples since the output was due. If a clamped value is in use, it counts all.
///   health  counts all samples since the output was last used unchanged; kClampedBit: a clamped value is in use
constexpr ChannelHealth due_health(ChannelHealth health, std::uint32_t not_due) {
  const std::uint32_t count = health >> 2U, clamped = health >> 1U & 1U;
  const std::uint32_t late = (count - not_due) * static_cast<std::uint32_t>(count > most_missing(not_due));
  const std::uint32_t held = late << 2U | static_cast<std::uint32_t>(late > 0);
  return static_cast<ChannelHealth>(clamped * (count << 2U | kClampedBit) + (1U - clamped) * held);
}

/// Returns the health of a slow output with may_fail (sensor_failures.h) that has no value now and had none in `missed`
/// samples before. It counts the samples since its last value. A clamped value is in use until the output is late.
constexpr ChannelHealth absent_health(ChannelHealth last, int missed, std::uint32_t not_due) {
  const ChannelHealth next = counted_on(last, static_cast<std::uint32_t>(missed) + 1, kHeldBit | (last & kClampedBit));
  const bool late = (next >> 2U) > most_missing(not_due);
  return static_cast<ChannelHealth>(next & ~(static_cast<std::uint32_t>(late) * kClampedBit));
}

/// Returns the health for the status of a slow output with may_fail: kOk until it is late, then kHeld, never kStale.
constexpr ChannelHealth due_health_of_failing(ChannelHealth health, std::uint32_t not_due) {
  const std::uint32_t clamped = health >> 1U & 1U;
  const ChannelHealth due = due_health(static_cast<ChannelHealth>(health & ~std::uint32_t{kClampedBit}), not_due);
  const auto held = static_cast<ChannelHealth>(due == 0 ? 0 : kHeldOnce);
  return static_cast<ChannelHealth>(clamped * (1U << 2U | kClampedBit) + (1U - clamped) * held);
}

/// Returns the health of a slow output after a sample. It keeps kClampedBit while the clamped value is in use.
template <Arithmetic kArithmetic>
constexpr ChannelHealth next_slow_health(ChannelHealth last, bool good, bool clamped, std::uint32_t not_due) {
  const ChannelHealth missed = counted_on(last, 1, kHeldBit | (last & kClampedBit));
  const auto late = static_cast<ChannelHealth>(due_health(last, not_due) * static_cast<int>((last & 3U) != 0));
  const ChannelHealth again = counted_on(late, 1, kClampedBit);
  const ChannelHealth worse = select<kArithmetic>(good, again, missed);
  return select<kArithmetic>(good & !clamped, ChannelHealth{0}, worse);
}

/// Returns the number of samples that are missing in a step over dt_s seconds. Up to 1.5 sample periods are jitter: 0.
template <class Scalar>
constexpr int missed_samples(Scalar dt_s, Scalar sample_period_s) {
  const Scalar periods = dt_s / sample_period_s;
  return periods > Scalar(1.5) ? static_cast<int>(periods + Scalar(0.5)) - 1 : 0;
}

/// Returns the status of one channel. Once `stale_after` samples in a row were not used unchanged, the status is kStale
/// or kOutOfRange.
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
  Scalar wrap[kNy];  ///< full turn: 2 pi for an angle, a power of two for another relative output; 0: clamped instead

  /// Validates the readings of a sample. `accepted` holds the last good readings; usable values overwrite them. An
  /// output that wraps ends within half a turn of its last good value. Updates the health of each channel. Returns true
  /// if a reading was held. The data decides no branch, so that the time is constant (arithmetic.h). Model: for
  /// not_due(); void: every output has a value in every sample.
  template <Arithmetic kArithmetic, class Model = void>
  constexpr bool validate(const Vector<Scalar, kNy>& y, Scalar (&accepted)[kNy], ChannelHealth* health) const {
    bool held = false;
    for (int j = 0; j < kNy; ++j) {
      const bool below = y[j] < min[j];
      const bool above = y[j] > max[j];
      bool good = is_finite(y[j]), clamped = false;
      // Each branch calls select() itself: a shared result would be moved between register files.
      if (wrap[j] > Scalar(0)) {  // the model decides this branch, not the data
        good = good & !below & !above;
        // If y is within half a turn of the last value, y is used bit for bit. If the turn is a power of two, removing
        // whole turns is exact.
        const Scalar from = select<kArithmetic>(good, y[j], accepted[j]);
        const Scalar turns = whole_turns<kArithmetic>(from - accepted[j], wrap[j]);
        accepted[j] = from - rounded<Scalar>(wrap[j] * turns);
      } else {
        clamped = good & (below | above);
        const Scalar limit = select<kArithmetic>(below, min[j], max[j]);
        const Scalar within = select<kArithmetic>(!clamped, y[j], limit);
        accepted[j] = select<kArithmetic>(good, within, accepted[j]);
      }
      // The model decides this branch, not the data.
      health[j] = not_due<Model>(j) > 0 ? next_slow_health<kArithmetic>(health[j], good, clamped, not_due<Model>(j))
                                        : next_health<kArithmetic>(health[j], good, clamped);
      held |= !good;
    }
    return held;
  }

  /// Returns true if validation can have stored `y`: every value is within its range, or within its first turn.
  constexpr bool may_hold(const Scalar (&y)[kNy]) const {
    bool good = true;
    for (int j = 0; j < kNy; ++j) good = good & may_hold(j, y[j]);
    return good;
  }
  constexpr bool may_hold(int j, Scalar y) const {
    const bool in_range = (y >= min[j]) & (y <= max[j]);
    const bool in_turn = (y >= -wrap[j]) & (y <= wrap[j]);  // stored angles are near zero, whatever the sensor's range
    return is_finite(y) & (in_range | ((wrap[j] > Scalar(0)) & in_turn));
  }

  /// Returns the angle without its whole turns, in [-turn / 2, turn / 2].
  template <Arithmetic kArithmetic>
  NLO_SHARED_WITHOUT_FPU static constexpr Scalar wrapped(Scalar angle, Scalar turn) {
    return angle - rounded<Scalar>(turn * whole_turns<kArithmetic>(angle, turn));
  }

  /// Returns angle / turn, rounded to an integer; 0 if an int32 cannot hold it.
  template <Arithmetic kArithmetic>
  NLO_SHARED_WITHOUT_FPU static constexpr Scalar whole_turns(Scalar angle, Scalar turn) {
    // This case needs no division: turn / 2 is exact, so |angle| <= turn / 2 exactly if |angle / turn| <= 1/2.
    if constexpr (!kConstantTime<kArithmetic>) {
      const Scalar half_turn = turn * Scalar(0.5);
      if (angle >= -half_turn && angle <= half_turn) [[likely]]
        return Scalar(0);
    }
    // Validated angles have at most 2^17 turns. Only a bit flip makes more.
    const Scalar all = angle / turn;
    const Scalar turns = select<kArithmetic>(is_below(all, Scalar(0x1p30)), all, Scalar(0));
    // Exactly half a turn is not unwrapped; otherwise an angle at the boundary would flip, and z with it, at every
    // step.
    const bool none = (turns >= Scalar(-0.5)) & (turns <= Scalar(0.5));
    const Scalar half = select<kArithmetic>(turns < Scalar(0), Scalar(-0.5), Scalar(0.5));
    return select<kArithmetic>(none, Scalar(0), static_cast<Scalar>(static_cast<std::int32_t>(turns + half)));
  }
};
template <class Scalar, int kNy>
using OutputRange [[deprecated("it is called ReadingRange")]] = ReadingRange<Scalar, kNy>;

}  // namespace nlo::inline NLO_ISA
