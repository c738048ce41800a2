// SPDX-License-Identifier: MIT
// Counts the instructions of one step and estimate on an emulated board, and the stack that they touch. table.sh prints
// the table.
//
// The emulator lets an instruction take 1 ns of the board's time (-icount shift=0), so SysTick counts instructions: 40
// of them per tick at 25 MHz. How many it is here is calibrated against code of known length.
#include <cstdint>

#include "bench/embedded/fly.h"
#include "toolchains/cortex_m/console.h"

namespace {

struct SysTick {
  volatile std::uint32_t control, reload, current, calibration;
};
SysTick& systick() {
  return *reinterpret_cast<SysTick*>(0xE000E010);
}

/// Ticks that `calls` calls take.
template <class Function>
__attribute__((noinline)) std::uint32_t ticks(Function function, int calls) {
  const std::uint32_t start = systick().current;
  for (int i = 0; i < calls; ++i) function();
  return (start - systick().current) & 0xffffffU;
}

__attribute__((noinline)) void nothing() {
  __asm__ volatile("");
}
__attribute__((noinline)) void one_hundred() {
  __asm__ volatile(".rept 100\nnop\n.endr");
}
__attribute__((noinline)) void two_hundred() {
  __asm__ volatile(".rept 200\nnop\n.endr");
}

/// Bytes below the caller's frame that a call writes: painted before, looked at after.
__attribute__((noinline)) std::uint32_t stack_of_a_call() {
  constexpr int kPainted = 600;  // words
  constexpr std::uint32_t kPaint = 0xa5a5a5a5U;
  std::uint32_t* top;
  __asm__ volatile("mov %0, sp" : "=r"(top));
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
  systick().reload = 0xffffff;
  systick().current = 0;
  systick().control = 5;  // core clock, no interrupt
  constexpr int kCalls = 50;
  constexpr std::uint32_t kKnown = 200 * 10'000;
  const std::uint32_t known = ticks(two_hundred, 10'000) - ticks(nothing, 10'000);
  step_and_estimate();  // the first one only starts the observer

  const std::uint32_t counted = ticks(step_and_estimate, kCalls) - ticks(nothing, kCalls);
  const auto instructions =
      static_cast<std::uint32_t>((static_cast<std::uint64_t>(counted) * kKnown + known * kCalls / 2) / known / kCalls);
  write("instructions ", instructions);
  write(" stack ", stack_of_a_call());
  write(" observer ", observer_bytes);
  board::write("\n");
  // The control: half the code takes half the ticks, or what is read is no count of instructions.
  const std::uint32_t half = ticks(one_hundred, 10'000) - ticks(nothing, 10'000);
  const bool proportional = 2 * half <= known + 4 && known <= 2 * half + 4;
  return proportional && known > 1000 && x_hat[0] < 1e6F && x_hat[0] > -1e6F ? 0 : 1;
}
