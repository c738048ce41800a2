// SPDX-License-Identifier: MIT
// Searches for the most instructions that each call of an observer takes on an emulated board, over inputs and states:
// NaN, infinities, denormals, the largest floats, missing readings, values at their limits and just beyond, steps of
// every length, states after such inputs, and states that a flipped bit or a wild pointer has changed.
#include <cstdint>
#include <cstring>

#include "bench/embedded/instruction_clock.h"
#include "bench/embedded/worst_case/calls.h"
#include "toolchains/console.h"

#ifndef NLO_CASES
#define NLO_CASES 1000
#endif

namespace {

constexpr int kLargestState = 512, kMostValues = 16;
constexpr std::uint32_t kMostSteps = 40'000;

/// A linear congruential generator, of which only the upper bits are used.
struct Random {
  std::uint32_t state = 1;
  std::uint32_t operator()(std::uint32_t below) {
    state = state * 1664525U + 1013904223U;
    return static_cast<std::uint32_t>((std::uint64_t{state} * below) >> 32U);
  }
  std::uint32_t bits() { return (*this)(1U << 16U) << 16U | (*this)(1U << 16U); }
};
Random random;

float as_float(std::uint32_t bits) {
  float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}
float between(float low, float high) {
  return low + (high - low) * static_cast<float>(random(1U << 20U)) / static_cast<float>(1U << 20U);
}

/// NaN of both signs, infinities, zeros, denormals, the largest and the smallest numbers, and the limits of is_finite
/// and is_below.
constexpr std::uint32_t kHard[] = {0x7fc00000, 0xffc00000, 0x7f800001, 0x7f800000, 0xff800000, 0x00000000, 0x80000000,
                                   0x00000001, 0x807fffff, 0x00800000, 0x7f7fffff, 0xff7fffff, 0x71800000, 0xf17fffff,
                                   0x0d800000, 0x4e800000, 0xce7fffff, 0x3f000000, 0xbf000000, 0x40f80000};

float hard() {
  return as_float(kHard[random(sizeof(kHard) / sizeof(kHard[0]))]);
}

float reading() {
  switch (random(6)) {
    case 0:
      return hard();
    case 1:
      return as_float(random.bits());
    case 2:
      return random(2) != 0 ? called.lowest : called.highest;
    case 3:
      return 1.001F * (random(2) != 0 ? called.lowest : called.highest);
    default:
      return between(called.lowest, called.highest);
  }
}

float duration() {
  switch (random(6)) {
    case 0:
      return hard();
    case 1:
      return called.longest;
    case 2:
      return 1.001F * called.longest;
    case 3:
      return called.sample_period_s;
    default:
      return between(0.0F, called.longest);
  }
}

/// The input of a call: the state of the observer and the arguments.
struct Case {
  unsigned char state[kLargestState];
  float y[kMostValues], u[kMostValues], dt_s;
};
unsigned char fresh[kLargestState];
Case tried, usual;  ///< the current case; a case from which the search often succeeds

/// Sets the state, except the pointers to models.
void restore() {
  std::memcpy(called.state, tried.state, called.pointer);
  if (called.pointer < called.bytes) {
    const unsigned behind = called.pointer + static_cast<unsigned>(sizeof(void*));
    std::memcpy(called.state + behind, tried.state + behind, called.bytes - behind);
  }
}

void choose_inputs() {
  if (random(4) == 0) return;  // repeats the inputs, like a frozen sensor
  const bool as_usual = random(2) != 0;
  for (float& y : tried.y) y = as_usual ? between(called.lowest, called.highest) : reading();
  for (float& u : tried.u) u = as_usual ? between(-1.0F, 1.0F) : reading();
  tried.dt_s = duration();
}

/// Restores the pointer to the monitor's model, which a changed state must not replace.
void restore_pointer() {
  if (called.pointer < called.bytes) std::memcpy(called.state + called.pointer, fresh + called.pointer, sizeof(void*));
}

/// Sets `tried` to a state that follows from the last one, or to a corrupted one.
void choose_state() {
  switch (random(8)) {
    case 0:
      std::memcpy(called.state, fresh, called.bytes);
      break;
    case 1:
      called.state[random(called.bytes)] ^= static_cast<unsigned char>(1U << random(8));
      break;
    case 2: {
      const float value = hard();
      std::memcpy(called.state + 4 * random(called.bytes / 4), &value, sizeof(value));
      break;
    }
    case 3:  // any reachable z, so that the following steps saturate
      for (unsigned at = 0; at + 4 <= called.bytes - 4; at += 4) {
        const float value = as_float((random.bits() & 0x807fffffU) | (100U + random(100)) << 23U);
        std::memcpy(called.state + at, &value, sizeof(value));
      }
      break;
    default:
      break;
  }
  std::memcpy(tried.state, called.state, called.bytes);
  restore_pointer();
}

/// Changes some values of `tried` by similar amounts, but not the flags after z, y and the held inputs.
void move_some() {
  constexpr float kScales[] = {0.1F, 0.3F, 1.0F, 3.0F, 10.0F, 30.0F, 100.0F, 300.0F};
  constexpr std::uint32_t kShares[] = {50, 300, 1000};  // thousandths
  const float scale = kScales[random(8)];
  const std::uint32_t share = kShares[random(3)];
  const auto move = [&](float value) { return random(1000) < share ? value + between(-scale, scale) : value; };
  const auto outputs = static_cast<unsigned>(called.outputs), inputs = static_cast<unsigned>(called.inputs);
  const unsigned flags = (2 * (outputs + inputs) + 2 + 3) / 4 * 4;
  for (unsigned at = 0; at + 4 <= called.bytes - flags; at += 4) {
    float value;
    std::memcpy(&value, tried.state + at, sizeof(value));
    value = move(value);
    std::memcpy(tried.state + at, &value, sizeof(value));
  }
  for (unsigned j = 0; j < outputs; ++j) tried.y[j] = move(tried.y[j]);
  for (unsigned j = 0; j < inputs; ++j) tried.u[j] = move(tried.u[j]);
  if (random(4) == 0) tried.dt_s = duration();
}

/// A call, and the worst case that was found.
struct Call {
  const char* name;
  void (*run)();
  std::uint32_t times = 1;  ///< number of calls to compare
  std::uint32_t most = 0;   ///< ticks of the worst case
  Case worst = {};
};
Call calls[] = {{"call_step", call_step},
                {"call_step_dt", call_step_dt},
                {"call_estimate", call_estimate},
#if NLO_MONITORED
                {"call_usable_outputs", call_usable_outputs},
                {"call_watch", call_watch}
#endif
};

/// Runs one sample of the observer and of its monitor.
void go_on() {
  call_step();
#if NLO_MONITORED
  call_watch();
  call_usable_outputs();
#endif
}

/// Returns the ticks of `times` calls of `tried`.
std::uint32_t ticks_of(void (*run)(), std::uint32_t times) {
  std::memcpy(call_y, tried.y, sizeof(call_y));
  std::memcpy(call_u, tried.u, sizeof(call_u));
  call_dt_s = tried.dt_s;
  return nlo::bench::ticks(
      [run] {
        restore();
        run();
      },
      static_cast<int>(times));
}

/// Stores `tried` if it is the worst so far.
bool look_at(Call& call) {
  const std::uint32_t counted = ticks_of(call.run, call.times);
  if (counted < call.most) return false;
  call.most = counted;
  call.worst = tried;
  return true;
}

/// Returns the instructions of a call of `tried`. It makes so many calls that the length of a tick does not matter.
std::uint32_t instructions(const Call& call, const nlo::bench::InstructionClock& clock) {
  const std::uint32_t times = call.times >= 50 ? 400 : 200;
  const std::uint32_t counted = ticks_of(call.run, times) - ticks_of(nlo::bench::nothing, times);
  return clock.instructions(counted, times) + 1;  // adds back the one instruction of `nothing`
}

/// Climbs from a case: changes some values again and again, and keeps changes that take no fewer ticks. `length`:
/// instructions of one call, which limits the number of changes.
void climb(Call& call, const Case& start, std::uint32_t length) {
  const std::uint32_t steps = NLO_CLIMB / (length * call.times);
  static Case best;
  best = tried = start;
  std::uint32_t most = ticks_of(call.run, call.times);
  for (std::uint32_t i = 0; i < (steps < kMostSteps ? steps : kMostSteps); ++i) {
    tried = best;
    move_some();
    const std::uint32_t counted = ticks_of(call.run, call.times);
    if (counted < most) continue;
    most = counted;
    best = tried;
  }
  tried = best;
  look_at(call);
}

}  // namespace

int main() {
  const nlo::bench::InstructionClock clock;
  if (called.bytes > kLargestState || called.outputs > kMostValues || called.inputs > kMostValues) return 1;
  std::memcpy(fresh, called.state, called.bytes);
  usual.dt_s = called.longest;
  for (int i = 0; i < 10; ++i) {
    call_y[0] = 0.5F * (called.lowest + called.highest);
    go_on();
  }
  std::memcpy(usual.state, called.state, called.bytes);
  for (int i = 0; i < NLO_CASES; ++i) {
    choose_state();
    choose_inputs();
    for (Call& call : calls) {
      look_at(call);
      if (i == 20) {  // repeats short calls, so that ticks can compare them
        const std::uint32_t length = instructions(call, clock);
        call.times = length < 20'000 ? 20'000 / length + 1 : 1;
        call.most = 0;
      }
    }
    restore();
    go_on();
  }
  for (Call& call : calls) {
    tried = call.worst;
    const std::uint32_t length = instructions(call, clock);
    static Case from;
    from = call.worst;
    climb(call, from, length);
    climb(call, usual, length);
    tried = call.worst;
    board::write(call.name);
    board::write(" ");
    board::write(instructions(call, clock));
    board::write("\n");
  }
  return clock.counts() ? 0 : 1;
}
