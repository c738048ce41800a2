// SPDX-License-Identifier: MIT
// The periodic thread of the control loop: no drift; missed deadlines are counted and the elapsed time is reported.
#include "examples/control_loop/periodic_timer.h"

#include <gtest/gtest.h>

namespace {

constexpr std::int64_t kPeriodNs = 2'000'000;

void work_for(std::int64_t duration_ns) {
  const std::int64_t end_ns = monotonic_ns() + duration_ns;
  while (monotonic_ns() < end_ns) {
  }
}

// For work of any duration the wake-ups stay on the grid. A timer that sleeps for a period after the work would drift.
TEST(PeriodicTimer, StaysOnItsGridHoweverLongATickTakes) {
  PeriodicTimer timer(kPeriodNs);
  const std::int64_t start_ns = timer.deadline_ns();
  std::int64_t periods = 0;
  for (int tick = 0; tick < 50; ++tick) {
    periods += timer.wait();
    EXPECT_EQ(timer.deadline_ns(), start_ns + periods * kPeriodNs);
    EXPECT_GE(timer.lateness_ns(), 0) << "woken too early";
    EXPECT_GE(monotonic_ns(), timer.deadline_ns());
    work_for(kPeriodNs * (tick % 5) / 3);
  }
  EXPECT_EQ(periods, 50 + timer.missed());
}

TEST(PeriodicTimer, CountsMissedDeadlinesAndReportsTheElapsedTime) {
  PeriodicTimer timer(kPeriodNs);
  timer.wait();
  const int missed_before = timer.missed();
  work_for(kPeriodNs * 7 / 2);
  const int periods = timer.wait();
  EXPECT_GE(periods, 4);  // more if the machine is busy
  EXPECT_EQ(timer.missed() - missed_before, periods - 1);
}

}  // namespace
