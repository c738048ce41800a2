// SPDX-License-Identifier: MIT
// Flights with random events: measurements, inputs and time steps of any bits, damaged states from storage, and bit
// flips in the memory of an observer and of its monitor. After each step:
//   - the status exists and equals the status of the observer
//   - z is finite, and restore() accepts the state of save()
//   - an estimate with a good status is finite
//   - the level of a monitor is finite, and its alarm follows from its level
// At regular intervals the sensor is dead for a long time. Then the observer must report kStale and the monitor must
// raise an alarm, whatever happened before. Each observer, C++ or C99, flies behind the same calls, as a craft
// (craft.h).
#pragma once

#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/bits.h"

namespace nlo::hostile {

/// Ends the program and names the craft and the property that failed.
[[noreturn]] inline void crash(const char* craft, const char* what) {
  std::fprintf(stderr, "%s: property violated: %s\n", craft, what);
  std::abort();
}

/// Flies `steps` steps, or until the bits end.
template <class Craft>
void fly(Craft craft, const char* name, Bits& bits, long steps) {
  using Scalar = typename Craft::Scalar;
  constexpr int kMostInputs = 8;
  constexpr long kDeadEvery = 20'000, kMostHeld = 70'000;          // stale_after is below 2^14
  constexpr int kHeld = 2, kStale = 3, kDiverged = 6, kReset = 7;  // values of StepStatus
  static_assert(Craft::kNu <= kMostInputs);
  Scalar y[Craft::kNy], u[kMostInputs] = {};
  // An angle that a bit flip has moved by thousands of turns returns to its first turn in as many steps as the number
  // of turns has digits. The averages of a monitor forget a flip within its patience.
  constexpr int kHealing = 4;
  int healing = 0;     // steps with unchanged measurements until the observer has recovered from a flip
  long forgotten = 0;  // sample by which the monitor has recovered from a flip
  const auto check = [&](bool holds, const char* what) {
    if (!holds) crash(name, what);
  };
  const auto check_step = [&](int status) {
    check(status >= 0 && status <= kReset, "a status is one there is");
    const int said = craft.status();  // may also be kReset, if a step was rejected after a bit had flipped
    check(said == status || said == kReset, "the observer says what its step said");
    check(said == kReset || craft.latent_is_finite(), "z is finite");
    check(said > kHeld || craft.estimate_is_finite(), "an estimate with a good status is finite");
    const char* fault = craft.monitor_fault();
    if (fault != nullptr) crash(name, fault);
  };
  const auto fly_with_a_dead_sensor = [&](long samples) {
    for (Scalar& input : u) input = 0;
    for (int j = 0; j < Craft::kNy; ++j) y[j] = craft.low(j) / 2 + craft.high(j) / 2;
    // A flip may have moved z to 2^100. Until z has decayed, the gate of a monitor rejects kMostRejected readings in a
    // row.
    int status = kHeld;
    for (long k = 0; k < kMostHeld && status >= kHeld && status != kDiverged; ++k)
      check_step(status = craft.step(y, u));
    check(status < kHeld || status == kDiverged, "good measurements are accepted, whatever came before");
    long missed = 0;
    while (status != kStale && missed++ < kMostHeld) check_step(status = craft.step_missed(u));
    check(status == kStale, "a dead sensor makes the observer stale");
    for (; missed < samples; ++missed) check_step(craft.step_missed(u));
    check(craft.alarms(), "a dead sensor is an alarm");
  };
  for (long k = 0; k < steps && !bits.ended(); ++k) {
    for (int j = 0; j < Craft::kNy; ++j) y[j] = reading(bits, craft.low(j), craft.high(j));
    for (int i = 0; i < Craft::kNu; ++i) u[i] = reading(bits, Scalar(-1), Scalar(1));
    const auto event = bits(8), way = bits(8);
    if (event < 2) craft.reset();
    if (event >= 2 && event < 8) (void)craft.restore(&bits);
    if (event >= 8 && event < 16)
      check(craft.restore(nullptr) || healing > 0 || k < forgotten, "what is saved can be restored");
    if (event >= 16 && event < 32) {
      craft.flip(bits(24));
      healing = kHealing;
      forgotten = k + craft.patience();
    }
    int status;
    if (way < 32) {
      status = craft.step(y, u, reading(bits, Scalar(0), Scalar(3) * craft.period_s()));
    } else if (way < 36) {
      status = craft.step(y, u, reading(bits, Scalar(0), Scalar(1001) * craft.period_s()));
    } else if (way < 52) {
      status = craft.step_missed(u);
    } else if (way < 56) {
      status = craft.warm_start(y, u);
    } else {
      status = craft.step(y, u);
    }
    if (status == 0 && healing > 0) --healing;
    check_step(status);
    // The first dead time is long enough to saturate counters of 16 bits.
    if (k % kDeadEvery == kDeadEvery - 1) fly_with_a_dead_sensor(k < kDeadEvery ? kMostHeld : craft.patience());
  }
}

/// All crafts that were compiled into the program.
struct NamedCraft {
  const char* name;
  void (*fly)(Bits& bits, long steps);
};
extern const NamedCraft kFleet[];
extern const int kFleetSize;

}  // namespace nlo::hostile
