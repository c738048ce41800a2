// SPDX-License-Identifier: MIT
#pragma once

#include <stdint.h>

namespace px4 {
namespace wq_configurations {
static constexpr int nav_and_controllers = 1;
}

class ScheduledWorkItem {
 public:
  ScheduledWorkItem(const char*, int) { scheduled = this; }
  virtual ~ScheduledWorkItem() { scheduled = nullptr; }
  void ScheduleOnInterval(uint32_t interval_us, uint32_t = 0) { interval = interval_us; }
  void ScheduleClear() { interval = 0; }
  virtual void Run() = 0;
  inline static ScheduledWorkItem* scheduled = nullptr;  // the queue's view of it
  uint32_t interval = 0;
};
}  // namespace px4
