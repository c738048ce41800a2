// SPDX-License-Identifier: MIT
// Types of ROS 2 messages, from definitions as .msg files have them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace nlo::trainer {

enum class FieldKind : std::uint8_t {
  kBool,
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64,
  kString,
  kWideString,
  kMessage
};

struct MessageType;

struct MessageField {
  std::string name, type;  ///< type: "float64", "geometry_msgs/Vector3"
  FieldKind kind = FieldKind::kMessage;
  bool is_array = false;
  std::size_t length = 0;                ///< of an array; 0: its length is in the message
  const MessageType* message = nullptr;  ///< of kMessage; null: nobody has defined it
};

struct MessageType {
  std::string name;  ///< "sensor_msgs/Imu"
  std::vector<MessageField> fields;

  /// Null: there is none of that name.
  const MessageField* field(std::string_view wanted) const;
  std::vector<std::string> field_names() const;
};

class MessageTypes {
 public:
  /// With the common ones built in (built_in_messages.cpp).
  MessageTypes();
  MessageTypes(const MessageTypes&) = delete;
  MessageTypes& operator=(const MessageTypes&) = delete;

  /// `text`: of type `name`, then, after lines of =, "MSG: other/Type" and those it consists of. In place of what was
  /// there. Throws codegen::Error that quotes the line.
  void define(const std::string& name, std::string_view text);

  /// By "sensor_msgs/msg/Imu" or "sensor_msgs/Imu". Null: nobody has defined it.
  const MessageType* find(const std::string& name);

 private:
  void link();

  std::map<std::string, MessageType> types_;
  bool linked_ = false;
};

/// The definitions that are built in, as define() reads them.
std::string_view built_in_messages();

}  // namespace nlo::trainer
