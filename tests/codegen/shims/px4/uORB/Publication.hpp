// SPDX-License-Identifier: MIT
#pragma once

#define ORB_ID(topic) #topic

namespace uORB {
template <class Message>
class Publication {
 public:
  explicit Publication(const char*) {}
  bool publish(const Message& message) {
    last = message;
    ++count;
    return true;
  }
  inline static Message last{};
  inline static int count = 0;
};
}  // namespace uORB
