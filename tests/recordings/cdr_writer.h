// SPDX-License-Identifier: MIT
// Messages as ROS 2 serialises them, for tests: fields in their order, each at a multiple of its size.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace nlo::trainer {

class CdrWriter {
 public:
  explicit CdrWriter(bool little = true) : little_(little), bytes_({'\0', little ? '\1' : '\0', '\0', '\0'}) {}

  template <class T>
  CdrWriter& add(T value) {
    while ((bytes_.size() - 4) % sizeof(T) != 0) bytes_ += '\0';
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (!little_) std::reverse(raw, raw + sizeof(T));
    bytes_.append(raw, sizeof(T));
    return *this;
  }
  CdrWriter& add(const std::string& text) {
    add(static_cast<std::uint32_t>(text.size() + 1));
    bytes_.append(text.c_str(), text.size() + 1);
    return *this;
  }
  template <class T>
  CdrWriter& add(const std::vector<T>& sequence) {
    add(static_cast<std::uint32_t>(sequence.size()));
    for (const T& value : sequence) add(value);
    return *this;
  }
  template <class T>
  CdrWriter& repeat(int times, T value) {
    for (int i = 0; i < times; ++i) add(value);
    return *this;
  }
  CdrWriter& header(std::int64_t stamp_ns, const std::string& frame) {
    return add(static_cast<std::int32_t>(stamp_ns / 1000000000))
        .add(static_cast<std::uint32_t>(stamp_ns % 1000000000))
        .add(frame);
  }
  const std::string& bytes() const { return bytes_; }

 private:
  bool little_;
  std::string bytes_;
};

/// A sensor_msgs/Imu whose acceleration is (x, 2 x, 3 x) and whose rate is (-x, -2 x, -3 x).
inline std::string imu(std::int64_t stamp_ns, double x, bool little = true) {
  CdrWriter message(little);
  message.header(stamp_ns, "imu_link").add(0.0).add(0.0).add(0.0).add(1.0).repeat(9, 7.0);
  message.add(-x).add(-2.0 * x).add(-3.0 * x).repeat(9, 7.0).add(x).add(2.0 * x).add(3.0 * x).repeat(9, 7.0);
  return message.bytes();
}

}  // namespace nlo::trainer
