// SPDX-License-Identifier: MIT
// The most instructions that each call of an observer takes on an emulated board, over inputs and states that look for
// it: not-a-number, infinities, denormals, the largest floats, missing readings, values at their limits and just
// beyond, steps of every length, states that came so and states that a flipped bit or a wild pointer has spoilt.
#include <cstdint>
#include <cstring>

#include "bench/embedded/instruction_clock.h"
#include "bench/embedded/worst_case/calls.h"
#include "toolchains/cortex_m/console.h"

namespace {

constexpr int kLargestState = 512;

/// A linear congruential generator, its upper bits.
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

/// Not-a-number of both signs, infinities, zeros, denormals, the largest and the smallest, and what is_finite and
/// is_below ask for.
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

void choose_inputs() {
  const bool usual = random(2) != 0;
  for (float& y : call_y) y = usual ? between(called.lowest, called.highest) : reading();
  for (float& u : call_u) u = usual ? between(-1.0F, 1.0F) : reading();
  call_dt_s = duration();
}

volatile unsigned waiting = 0;
unsigned char fresh[kLargestState], tried[kLargestState];

void restore() {
  std::memcpy(called.state, tried, called.bytes);
}

/// Leaves in `tried` a state that follows from the last one, or is spoilt.
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
    case 3:  // z wherever it can be, so that what follows saturates
      for (unsigned at = 0; at + 4 <= called.bytes - 4; at += 4) {
        const float value = as_float((random.bits() & 0x807fffffU) | (100U + random(100)) << 23U);
        std::memcpy(called.state + at, &value, sizeof(value));
      }
      break;
    default:
      break;
  }
  std::memcpy(tried, called.state, called.bytes);
}

/// One of the calls and the worst that was seen of it.
struct Call {
  const char* name;
  void (*run)();
  std::uint32_t most_ticks = 0, most = 0;
};
Call calls[] = {{"call_step", call_step}, {"call_step_dt", call_step_dt}, {"call_estimate", call_estimate}};

/// Counts a call to the instruction where it may be the worst: many times over, from the same state.
void look_at(Call& call, const nlo::bench::InstructionClock& clock) {
  using nlo::bench::ticks;
  restore();
  const std::uint32_t once = ticks(call.run, 1);
  if (once < call.most_ticks) return;
  call.most_ticks = once;
  const int times = once > 20'000 ? 4 : once > 1000 ? 64 : 256;
  const auto from_the_same = [times](void (*run)()) {
    return ticks(
        [run] {
          restore();
          run();
        },
        times);
  };
  const std::uint32_t counted = from_the_same(call.run) - from_the_same(nlo::bench::nothing);
  const std::uint32_t all = clock.instructions(counted, static_cast<std::uint32_t>(times)) + 1;  // `nothing` is one
  if (all > call.most) call.most = all;
}

}  // namespace

/// The control of bound.py: nothing in the code says when this ends.
extern "C" __attribute__((noinline)) void waits_for_data() {
  while (waiting != 0) {
  }
}

int main() {
  waits_for_data();
  const nlo::bench::InstructionClock clock;
  if (called.bytes > kLargestState) return 1;
  std::memcpy(fresh, called.state, called.bytes);
  for (int i = 0; i < NLO_CASES; ++i) {
    choose_state();
    choose_inputs();
    for (Call& call : calls) look_at(call, clock);
    restore();
    call_step();  // goes on from here
  }
  for (const Call& call : calls) {
    board::write(call.name);
    board::write(" ");
    board::write(call.most);
    board::write("\n");
  }
  return clock.counts() ? 0 : 1;
}
