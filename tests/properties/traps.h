// SPDX-License-Identifier: MIT
// Counts events that a control loop must not cause in flight: allocations, locks, page faults.
#pragma once

#include <cstdint>

namespace nlo::testing {

/// True if a sanitizer replaces malloc, so that only operator new can be watched.
#if defined(__SANITIZE_ADDRESS__)
inline constexpr bool kUnderSanitizer = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
inline constexpr bool kUnderSanitizer = true;
#else
inline constexpr bool kUnderSanitizer = false;
#endif
#else
inline constexpr bool kUnderSanitizer = false;
#endif

/// Records the allocations, locks and faults of this thread during its lifetime. One at a time.
class Trap {
 public:
  Trap();
  ~Trap() { disarm(); }
  Trap(const Trap&) = delete;
  Trap& operator=(const Trap&) = delete;

  /// Stops counting; the counts stay.
  void disarm();
  int allocations() const;
  /// Calls that lock a mutex or a read-write lock, or wait for a condition.
  int locks() const;
  /// Page faults of this thread between construction and disarm().
  long page_faults() const { return faults_after_ - faults_before_; }

 private:
  long faults_before_ = 0, faults_after_ = 0;
};

}  // namespace nlo::testing
