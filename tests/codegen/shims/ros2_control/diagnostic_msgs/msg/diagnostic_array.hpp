// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

#include <controller_interface/chainable_controller_interface.hpp>

namespace diagnostic_msgs::msg {
struct KeyValue {
  std::string key, value;
};
struct DiagnosticStatus {
  enum : unsigned char { OK, WARN, ERROR, STALE };
  unsigned char level = OK;
  std::string name, message, hardware_id;
  std::vector<KeyValue> values;
};
struct DiagnosticArray {
  struct {
    rclcpp::Time stamp;
  } header;
  std::vector<DiagnosticStatus> status;
};
}  // namespace diagnostic_msgs::msg
