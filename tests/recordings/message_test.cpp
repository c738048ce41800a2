// SPDX-License-Identifier: MIT
// Numbers out of messages, by definitions: those that are built in and those of a bag; and what is no such message.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "codegen/base/error.h"
#include "tests/recordings/cdr_writer.h"
#include "tests/recordings/refusal.h"
#include "tests/support/scratch_directory.h"
#include "trainer/recordings/cdr_message.h"
#include "trainer/recordings/recording.h"

namespace nlo::trainer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsSupersetOf;

double number(MessageTypes& types, const std::string& type, const std::string& path, const std::string& bytes) {
  const MessageType* known = types.find(type);
  if (known == nullptr) throw codegen::Error("no " + type);
  std::vector<MessageValue> values = {MessageValue(*known, path)};
  read_message(*known, bytes, values);
  return values[0].value;
}

std::string error_of(MessageTypes& types, const std::string& type, const std::string& path, const std::string& bytes) {
  try {
    number(types, type, path, bytes);
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return "";
}

TEST(Messages, FindNumbersBehindTextsAndArraysInBothByteOrders) {
  MessageTypes types;
  for (const bool little : {true, false}) {
    const std::string bytes = imu(1700000000123456789, 0.1, little);
    EXPECT_EQ(number(types, "sensor_msgs/msg/Imu", "linear_acceleration.z", bytes), 0.1 * 3.0);
    EXPECT_EQ(number(types, "sensor_msgs/Imu", "angular_velocity.y", bytes), -0.2);
    EXPECT_EQ(number(types, "sensor_msgs/Imu", "orientation.w", bytes), 1.0);
    EXPECT_EQ(number(types, "sensor_msgs/Imu", "angular_velocity_covariance[8]", bytes), 7.0);
    EXPECT_EQ(number(types, "sensor_msgs/Imu", "header.stamp.sec", bytes), 1700000000.0);
    EXPECT_EQ(number(types, "sensor_msgs/Imu", "header.stamp.nanosec", bytes), 123456789.0);
    EXPECT_NEAR(number(types, "sensor_msgs/Imu", "header.stamp", bytes), 1700000000.123456789, 1e-6);
  }
}

TEST(Messages, FindJointsByNumberAndByNameWhereverTheyStand) {
  MessageTypes types;
  const std::vector<double> none;
  for (const bool swapped : {false, true}) {
    CdrWriter message;
    message.header(5, "").add(swapped ? std::vector<std::string>{"elbow", "wrist"}
                                      : std::vector<std::string>{"wrist", "elbow"});
    message.add(swapped ? std::vector<double>{2.0, 1.0} : std::vector<double>{1.0, 2.0}).add(none).add(none);
    EXPECT_EQ(number(types, "sensor_msgs/JointState", "position[elbow]", message.bytes()), 2.0);
    EXPECT_EQ(number(types, "sensor_msgs/JointState", "position[0]", message.bytes()), swapped ? 2.0 : 1.0);
    EXPECT_TRUE(std::isnan(number(types, "sensor_msgs/JointState", "position[hand]", message.bytes())));
    EXPECT_TRUE(std::isnan(number(types, "sensor_msgs/JointState", "velocity[elbow]", message.bytes())));
    EXPECT_TRUE(std::isnan(number(types, "sensor_msgs/JointState", "position[2]", message.bytes())));
  }
}

TEST(Messages, ReadDefinitionsWithConstantsBoundsDefaultsAndTypesOfTheirOwn) {
  MessageTypes types;
  types.define("rig_msgs/msg/State", R"(# a rig
uint8 MODE_OFF=0
uint8 MODE_ON = 1   # a constant
string<=8 label
uint8 mode 1
float32[<=4] gains
Axis[2] axes
bool ok
================================================================================
MSG: rig_msgs/Axis
int16 counts
float64 angle 0.5
)");
  CdrWriter message;
  message.add(std::string("abc")).add(std::uint8_t{1}).add(std::vector<float>{0.5F, 0.25F});
  message.add(std::int16_t{-3}).add(1.5).add(std::int16_t{4}).add(2.5).add(std::uint8_t{1});
  EXPECT_EQ(number(types, "rig_msgs/msg/State", "mode", message.bytes()), 1.0);
  EXPECT_EQ(number(types, "rig_msgs/msg/State", "gains[1]", message.bytes()), 0.25);
  EXPECT_EQ(number(types, "rig_msgs/msg/State", "axes[1].counts", message.bytes()), 4.0);
  EXPECT_EQ(number(types, "rig_msgs/msg/State", "axes[1].angle", message.bytes()), 2.5);
  EXPECT_EQ(number(types, "rig_msgs/msg/State", "ok", message.bytes()), 1.0);
  EXPECT_THAT(numbers_in(*types.find("rig_msgs/State"), message.bytes()),
              ElementsAre("mode", "gains[0]", "gains[1]", "ok"));
  EXPECT_THAT(error_of(types, "rig_msgs/State", "axes[1].speed", message.bytes()),
              HasSubstr("rig_msgs/Axis has no \"speed\", it has counts, angle"));
  EXPECT_THAT(error_of(types, "rig_msgs/State", "axes.angle", message.bytes()),
              HasSubstr("is an array: write axes[0]"));
  EXPECT_THAT(error_of(types, "rig_msgs/State", "mode[1]", message.bytes()), HasSubstr("mode is not an array"));
  EXPECT_THAT(error_of(types, "rig_msgs/State", "label", message.bytes()), HasSubstr("label is text"));
  EXPECT_THAT(error_of(types, "rig_msgs/State", "axes[0]", message.bytes()),
              HasSubstr("name one of its fields, counts, angle"));
  EXPECT_THROW(types.define("a/B", "float64"), codegen::Error);
  EXPECT_THROW(types.define("a/B", "float64[x] y"), codegen::Error);
}

TEST(Messages, RefuseAMessageThatEndsAnywhere) {
  MessageTypes types;
  const std::string whole = imu(1, 2.0);
  for (std::size_t length = 0; length < whole.size(); ++length)
    ASSERT_NE(error_of(types, "sensor_msgs/Imu", "orientation.x", whole.substr(0, length)), "") << length;
  EXPECT_EQ(error_of(types, "sensor_msgs/Imu", "orientation.x", whole), "");
}

TEST(Messages, EndWhateverTheirBytesAndDefinitionsAre) {
  MessageTypes types;
  types.define("a/Self", "a/Self inner\nfloat64 x\n");
  types.define("a/Many", "a/Self[] inner\nfloat64 x\n");
  types.define("a/Huge", "a/Empty[4000000000] inner\nfloat64 x\n");
  types.define("a/Empty", "");
  types.define("a/Unknown", "b/Nothing inner\nfloat64 x\n");
  const std::string zeros(200, '\0'), full = std::string(4, '\0') + std::string(200, '\xff');
  for (const char* type : {"a/Self", "a/Many", "a/Huge", "a/Unknown"})
    EXPECT_NE(error_of(types, type, "x", full), "") << type;
  EXPECT_THAT(error_of(types, "a/Unknown", "x", zeros), HasSubstr("has a b/Nothing"));
  std::uint32_t random = 1;
  std::string bytes = imu(1, 2.0);
  for (int i = 0; i < 20000; ++i) {
    random = random * 1664525U + 1013904223U;
    bytes[(random >> 8) % bytes.size()] = static_cast<char>(random >> 24);
    error_of(types, "sensor_msgs/Imu", "linear_acceleration.x", bytes);
    error_of(types, "sensor_msgs/JointState", "position[elbow]", bytes);
    error_of(types, "std_msgs/Float64MultiArray", "data[1]", bytes);
  }
}

TEST(Recordings, KnowTheirKindByTheirFirstBytesOrTheirEnding) {
  const ScratchDirectory folder;
  EXPECT_FALSE(is_recording(folder.write("log.csv", "t,y\n0,1\n1,2\n")));
  EXPECT_FALSE(is_recording(folder.path("nothing.csv")));
  EXPECT_TRUE(is_recording(folder.write("empty.mat", "")));
  EXPECT_TRUE(is_recording(folder.write("log.bin", std::string("SQLite format 3\0", 16))));
  EXPECT_THAT(refusal(folder.write("log.mcap", "\x89MCAP0\r\n"), {}),
              HasSubstr("log.mcap: is an MCAP file: ros2 bag convert"));
  EXPECT_THAT(refusal(folder.write("log.bag", "#ROSBAG V2.0"), {}), HasSubstr("ROS 1"));
  EXPECT_THAT(refusal(folder.write("empty.mat", ""), {}), HasSubstr("empty.mat: "));
  EXPECT_THAT(refusal(folder.write("empty.db3", ""), {}), HasSubstr("empty.db3: "));
}

}  // namespace
}  // namespace nlo::trainer
