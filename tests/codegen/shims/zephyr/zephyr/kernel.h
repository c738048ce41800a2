// SPDX-License-Identifier: MIT
// A minimal Zephyr kernel for a generated sample: its timer has always just expired, and it ends after 3 s of simulated
// time.
#pragma once

#include <cstdint>
#include <cstdlib>

struct k_timer {
  uint32_t period_us, time_us;
};
#define K_TIMER_DEFINE(name, expired, stopped) static k_timer name
#define K_USEC(us) us

inline uint32_t& simulated_us() {
  static uint32_t now_us = 0;
  return now_us;
}
inline void k_timer_start(k_timer* timer, uint32_t, uint32_t period_us) {
  timer->period_us = period_us;
}
inline uint32_t k_timer_status_sync(k_timer* timer) {
  const uint32_t periods = simulated_us() == 40 * timer->period_us ? 3 : 1;  // once, samples are missed
  simulated_us() += periods * timer->period_us;
  if (simulated_us() > 3000000U) std::exit(0);
  return periods;
}
inline uint32_t k_uptime_get_32() {
  return simulated_us() / 1000U;
}
