// SPDX-License-Identifier: MIT
// Numbers out of a message as ROS 2 serialises it (CDR, XCDR1): fields in their order, each at a multiple of its size.
#pragma once

#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "trainer/recordings/message_types.h"

namespace nlo::trainer {

/// A number within a message: "linear_acceleration.x", "position[2]", "position[elbow]" (by the message's array name).
struct MessageValue {
  struct Step {
    std::size_t field = 0;
    bool is_indexed = false;
    std::size_t index = 0;
    std::string name;  ///< in place of an index
  };
  std::vector<Step> steps;
  bool is_time = false;  ///< a Time or a Duration as a whole: seconds and nanoseconds
  double value = std::numeric_limits<double>::quiet_NaN();  ///< NaN: the message has none
  std::int64_t nanoseconds = 0;                             ///< of is_time

  /// Of messages of `type`. Throws codegen::Error with the fields that there are.
  MessageValue(const MessageType& type, std::string_view path);
};

/// Sets `values` from `bytes`, a message of `type`. Throws codegen::Error, which says where, when the bytes are not
/// such a message.
void read_message(const MessageType& type, std::string_view bytes, std::vector<MessageValue>& values);

/// The paths of all numbers in the message but headers, covariances, long arrays and what has no definition.
std::vector<std::string> numbers_in(const MessageType& type, std::string_view bytes);

}  // namespace nlo::trainer
