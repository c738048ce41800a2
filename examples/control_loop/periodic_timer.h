// SPDX-License-Identifier: MIT
// Keeps a fixed rate by absolute deadlines: it sleeps "until" a time and never "for" a time, so that the duration of
// ticks does not add up to a drift. Also has calls by which a Linux process keeps its deadlines better.
#pragma once

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <time.h>

#include <cerrno>
#include <cstdint>

/// Returns the time of CLOCK_MONOTONIC [ns].
inline std::int64_t monotonic_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

class PeriodicTimer {
 public:
  explicit PeriodicTimer(std::int64_t period_ns) : period_ns_(period_ns), deadline_ns_(monotonic_ns()) {}

  /// Sleeps until the next deadline on the grid. Returns how many periods have passed: 1, or more if the last tick
  /// missed its deadline and whole periods were skipped.
  int wait() {
    const std::int64_t behind_ns = monotonic_ns() - (deadline_ns_ + period_ns_);
    const int periods = behind_ns < 0 ? 1 : static_cast<int>(behind_ns / period_ns_) + 2;
    missed_ += periods - 1;
    deadline_ns_ += periods * period_ns_;
    const timespec until{deadline_ns_ / 1'000'000'000, static_cast<long>(deadline_ns_ % 1'000'000'000)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
    }
    lateness_ns_ = monotonic_ns() - deadline_ns_;
    return periods;
  }

  /// Returns the deadline of the latest wait().
  std::int64_t deadline_ns() const { return deadline_ns_; }
  /// Returns the number of deadlines at which the loop was still working, or not yet awake.
  int missed() const { return missed_; }
  /// Returns how long after its deadline the latest wait() returned.
  std::int64_t lateness_ns() const { return lateness_ns_; }

 private:
  std::int64_t period_ns_;
  std::int64_t deadline_ns_;
  std::int64_t lateness_ns_ = 0;
  int missed_ = 0;
};

/// Keeps the pages of the process in memory, because a page fault takes longer than many steps.
inline bool lock_memory() {
  return mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}

/// Runs this thread before all ordinary ones.
inline bool use_real_time_priority() {
  sched_param parameters{};
  parameters.sched_priority = 80;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters) == 0;
}
