// SPDX-License-Identifier: MIT
// Runs an exported observer on a Cortex-M: a timer ticks at the model's sample period, each tick has a measurement
// (here replayed from flash), and the estimate is printed on the terminal of the host. On real hardware measure() would
// read an ADC, and report() would write to a radio.
#include <cstdint>
#include <iterator>

#include "console.h"
#include "recorded_measurement.h"
#include "van_der_pol.h"  // generated: nlo export, or nlo_add_model() in CMake

using nlo::van_der_pol::kModel;
using nlo::van_der_pol::State;

constinit static nlo::van_der_pol::Observer observer{kModel};

namespace {

constexpr int kSamples = static_cast<int>(std::size(kRecords));
constexpr int kSettled = 250;  // samples (5 s) before the error counts, because the observer starts at 0

// SysTick is the timer that every Cortex-M of these boards has. It counts core clocks down from a reload value.
struct SysTick {
  volatile std::uint32_t control, reload, current, calibration;
};
SysTick& systick() {
  return *reinterpret_cast<SysTick*>(0xE000E010);
}

#if defined(__ARM_ARCH_6M__)
constexpr std::uint32_t kCoreClockHz = 16'000'000;  // micro:bit
#else
constexpr std::uint32_t kCoreClockHz = 25'000'000;  // MPS2 boards
#endif

volatile std::uint32_t ticks = 0;

float measure(int k) {
  return kRecords[k].measured;
}

void start_timer() {
  systick().reload = static_cast<std::uint32_t>(kModel.sample_period_s * static_cast<float>(kCoreClockHz)) - 1;
  systick().current = 0;
  systick().control = 7;  // core clock, interrupt, enabled
}

void report(int k, float x1, float x2) {
  using board::write;
  write("t ");
  write(static_cast<float>(k) * kModel.sample_period_s);
  write(" s  measured ");
  write(kRecords[k].measured);
  write("  x1 ");
  write(x1);
  write(" (true ");
  write(kRecords[k].x1);
  write(")  x2 ");
  write(x2);
  write(" (true ");
  write(kRecords[k].x2);
  write(")\n");
}

float square(float v) {
  return v * v;
}

/// Returns a rough square root by Newton's method: exact enough to print. libm would be larger than this program.
float root(float v) {
  float r = v > 1.0F ? v : 1.0F;
  for (int i = 0; i < 20; ++i) r = 0.5F * (r + v / r);
  return r;
}

}  // namespace

extern "C" void SysTick_Handler() {
  ticks = ticks + 1;
}

int main() {
  start_timer();
  std::uint32_t handled = 0, overruns = 0;
  float squared_error = 0, squared_noise = 0;
  for (int k = 0; k < kSamples; ++k) {
    while (ticks == handled) __asm__ volatile("wfi");
    ++handled;

    if (observer.step(measure(k)) != nlo::StepStatus::kOk) board::write("measurement clamped or held\n");
    const auto x_hat = observer.estimate();

    if (ticks != handled) ++overruns;  // the tick took longer than the sample period
    if (k % 100 == 0) report(k, x_hat[State::x1], x_hat[State::x2]);
    if (k < kSettled) continue;
    squared_error += square(x_hat[State::x1] - kRecords[k].x1) + square(x_hat[State::x2] - kRecords[k].x2);
    squared_noise += square(kRecords[k].measured - kRecords[k].x1);
  }
  constexpr auto kJudged = static_cast<float>(kSamples - kSettled);
  board::write("estimation error ");
  board::write(root(squared_error / kJudged));
  board::write(" rms in both states; sensor ");
  board::write(root(squared_noise / kJudged));
  board::write(" in one; overruns ");
  board::write(overruns);
  board::write("\n");
  return squared_error < squared_noise && overruns == 0 ? 0 : 1;
}
