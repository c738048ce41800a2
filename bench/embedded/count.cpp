// SPDX-License-Identifier: MIT
// Counts the instructions of one step and estimate on an emulated board, and the stack that they use. table.sh prints
// the table.
#include <cstdint>

#include "bench/embedded/fly.h"
#include "bench/embedded/instruction_clock.h"
#include "toolchains/console.h"

namespace {

/// Returns the number of bytes below the caller's frame that a call writes: fills them before and compares after the
/// call.
__attribute__((noinline)) std::uint32_t stack_of_a_call() {
  constexpr int kPainted = 600;  // words
  constexpr std::uint32_t kPaint = 0xa5a5a5a5U;
  std::uint32_t* top;
#if defined(__riscv)
  __asm__ volatile("mv %0, sp" : "=r"(top));
#else
  __asm__ volatile("mov %0, sp" : "=r"(top));
#endif
  volatile std::uint32_t* word = top - kPainted;
  while (word < top) *word++ = kPaint;
  step_and_estimate();
  word = top - kPainted;
  while (word < top && *word == kPaint) ++word;
  return static_cast<std::uint32_t>(top - word) * 4;
}

void write(const char* name, std::uint32_t value) {
  board::write(name);
  board::write(value);
}

}  // namespace

int main() {
  using nlo::bench::ticks;
  const nlo::bench::InstructionClock clock;
  constexpr int kCalls = 50;
  step_and_estimate();  // not counted: the first step only starts the observer

  const std::uint32_t counted = ticks(step_and_estimate, kCalls) - ticks(nlo::bench::nothing, kCalls);
  write("instructions ", clock.instructions(counted, kCalls));
  write(" stack ", stack_of_a_call());
  write(" observer ", observer_bytes);
  board::write("\n");
  return clock.counts() && x_hat[0] < 1e6F && x_hat[0] > -1e6F ? 0 : 1;
}
