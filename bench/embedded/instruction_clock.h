// SPDX-License-Identifier: MIT
// Counts instructions on an emulated board. Each instruction takes 1 ns of the board's time (-icount shift=0), so
// SysTick counts 40 of them per tick at 25 MHz, and minstret of RISC-V counts each one. The number per tick is
// calibrated with code of known length.
#pragma once

#include <cstdint>

namespace nlo::bench {

#if defined(__riscv)
inline std::uint32_t count_now() {
  unsigned long count;
  __asm__ volatile("csrr %0, minstret" : "=r"(count));
  return static_cast<std::uint32_t>(count);
}
inline void start_counting() {}

/// Returns the ticks since `start`, an earlier count_now().
inline std::uint32_t ticks_since(std::uint32_t start) {
  return count_now() - start;
}
#else
struct SysTick {
  volatile std::uint32_t control, reload, current, calibration;
};
inline SysTick& systick() {
  return *reinterpret_cast<SysTick*>(0xE000E010);
}

inline std::uint32_t count_now() {
  return systick().current;
}
inline void start_counting() {
  systick().reload = 0xffffff;
  systick().current = 0;
  systick().control = 5;  // core clock, no interrupt
}

/// Returns the ticks since `start`, an earlier count_now(). The counter counts down and has 24 bits.
inline std::uint32_t ticks_since(std::uint32_t start) {
  return (start - count_now()) & 0xffffffU;
}
#endif

/// Returns the ticks of `calls` calls.
template <class Function>
__attribute__((noinline)) std::uint32_t ticks(Function function, int calls) {
  const std::uint32_t start = count_now();
  for (int i = 0; i < calls; ++i) function();
  return ticks_since(start);
}

__attribute__((noinline)) inline void nothing() {
  __asm__ volatile("");
}
__attribute__((noinline)) inline void one_hundred() {
  __asm__ volatile(".rept 100\nnop\n.endr");
}
__attribute__((noinline)) inline void two_hundred() {
  __asm__ volatile(".rept 200\nnop\n.endr");
}

/// Starts counting and determines the length of a tick.
class InstructionClock {
 public:
  InstructionClock() {
    start_counting();
    known_ = ticks(two_hundred, kCalls) - ticks(nothing, kCalls);
    half_ = ticks(one_hundred, kCalls) - ticks(nothing, kCalls);
  }

  /// Returns the instructions per call, for a number of ticks and of calls.
  std::uint32_t instructions(std::uint64_t counted, std::uint32_t calls) const {
    const std::uint64_t all = std::uint64_t{known_} * calls;
    return static_cast<std::uint32_t>((counted * (200 * kCalls) + all / 2) / all);
  }

  /// Returns true if half the code takes half the ticks, which shows that the counter counts instructions.
  bool counts() const { return known_ > 1000 && 2 * half_ <= known_ + 4 && known_ <= 2 * half_ + 4; }

 private:
  static constexpr int kCalls = 10'000;
  std::uint32_t known_, half_;  ///< ticks of kCalls times 200 instructions, and of kCalls times 100
};

}  // namespace nlo::bench
