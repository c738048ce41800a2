// SPDX-License-Identifier: MIT
// Bags of ROS 2 that the tests write: topics of several rates, stamps and receive times, damage.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sqlite3.h>

#include <cmath>

#include "codegen/base/error.h"
#include "tests/recordings/cdr_writer.h"
#include "tests/recordings/refusal.h"
#include "tests/support/scratch_directory.h"
#include "trainer/data/log_dataset.h"
#include "trainer/data/log_file.h"
#include "trainer/guess/log_guess.h"
#include "trainer/recordings/recording.h"

namespace nlo::trainer {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::int64_t kStart = 1700000000000000000, kMs = 1000000;

class BagWriter {
 public:
  explicit BagWriter(const std::string& path, bool definitions = false) {
    sqlite3_open(path.c_str(), &database_);
    run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, serialization_format TEXT "
        "NOT "
        "NULL, offered_qos_profiles TEXT NOT NULL)");
    run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data "
        "BLOB NOT "
        "NULL)");
    if (definitions)
      run("CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT NULL, encoding TEXT NOT NULL, "
          "encoded_message_definition TEXT NOT NULL, type_description_hash TEXT NOT NULL)");
    run("BEGIN");
  }
  ~BagWriter() {
    run("COMMIT");
    sqlite3_close(database_);
  }
  BagWriter(const BagWriter&) = delete;
  BagWriter& operator=(const BagWriter&) = delete;

  void run(const std::string& sql) {
    ASSERT_EQ(sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr), SQLITE_OK) << sqlite3_errmsg(database_);
  }
  int topic(const std::string& name, const std::string& type, const std::string& format = "cdr") {
    run("INSERT INTO topics VALUES(" + std::to_string(++topics_) + ", '" + name + "', '" + type + "', '" + format +
        "', '')");
    return topics_;
  }
  void message(int topic, std::int64_t time_ns, const std::string& bytes) {
    sqlite3_stmt* statement = nullptr;
    sqlite3_prepare_v2(database_, "INSERT INTO messages(topic_id, timestamp, data) VALUES(?, ?, ?)", -1, &statement,
                       nullptr);
    sqlite3_bind_int(statement, 1, topic);
    sqlite3_bind_int64(statement, 2, time_ns);
    sqlite3_bind_blob(statement, 3, bytes.data(), static_cast<int>(bytes.size()), SQLITE_TRANSIENT);
    EXPECT_EQ(sqlite3_step(statement), SQLITE_DONE);
    sqlite3_finalize(statement);
  }

 private:
  sqlite3* database_ = nullptr;
  int topics_ = 0;
};

std::string float64(double value) {
  return CdrWriter().add(value).bytes();
}

/// 50 messages of an IMU at 100 Hz, received 3 ms late and more, a truth at 40 Hz, and a command at 10 Hz.
std::string rig_bag(const ScratchDirectory& folder, const std::string& name = "rig.db3") {
  BagWriter bag(folder.path(name));
  const int imus = bag.topic("/imu/data", "sensor_msgs/msg/Imu"),
            truth = bag.topic("/truth", "geometry_msgs/msg/TwistStamped"),
            command = bag.topic("/command", "std_msgs/msg/Float64"),
            log = bag.topic("/rosout", "rcl_interfaces/msg/Log");
  bag.message(log, kStart, "whatever");
  for (int k = 0; k < 50; ++k) {
    const std::int64_t stamp = kStart + 10 * kMs * k;
    bag.message(imus, stamp + 3 * kMs + k % 2 * kMs, imu(stamp, 0.5 * k));
  }
  for (int k = 0; k < 21; ++k) {
    CdrWriter twist;
    twist.header(kStart + 25 * kMs * k, "map").repeat(6, 10.0 * k);
    bag.message(truth, kStart + 25 * kMs * k + kMs, twist.bytes());
  }
  for (int k = 0; k < 5; ++k) bag.message(command, kStart + 100 * kMs * k + 35 * kMs, float64(k));
  return folder.path(name);
}

TEST(Rosbag, HasTheRowsOfOneTopicAndTheOthersBetweenThem) {
  const ScratchDirectory folder;
  const Recording log = read_recording(rig_bag(folder), {"/imu/data/header.stamp",
                                                         {{"/imu/data/linear_acceleration.y"},
                                                          {"/truth/twist.linear.x", true},
                                                          {"/truth/twist.angular.z"},
                                                          {"/command/data"}}});
  EXPECT_THAT(log.headings, ElementsAre("/imu/data/header.stamp", "/imu/data/linear_acceleration.y",
                                        "/truth/twist.linear.x", "/truth/twist.angular.z", "/command/data"));
  ASSERT_EQ(log.numbers.rows(), 50);
  for (int k = 0; k < 50; ++k) {
    EXPECT_DOUBLE_EQ(log.numbers(k, 0), 0.01 * k);
    EXPECT_EQ(log.numbers(k, 1), 1.0 * k);
    EXPECT_NEAR(log.numbers(k, 2), 4.0 * k, 1e-9) << k;  // 10 a step of 25 ms, by lines
    const int newest = 10 * k / 25;                      // and the newest alone, once
    const bool is_new = k == 0 || newest > 10 * (k - 1) / 25;
    EXPECT_EQ(std::isnan(log.numbers(k, 3)), !is_new) << k;
    EXPECT_TRUE(!is_new || log.numbers(k, 3) == 10.0 * newest);
    EXPECT_EQ(std::isnan(log.numbers(k, 4)), k % 10 != 4);  // received at 35 ms, before the stamp of 40 ms
  }
  const Recording received =
      read_recording(rig_bag(folder, "again.db3"), {"/imu/data", {{"/imu/data/linear_acceleration.y"}}});
  EXPECT_NEAR(received.numbers(1, 0), 0.011, 1e-12);
}

TEST(Rosbag, InterpolatesAnAngleTheShorterWayAndNothingAcrossAHole) {
  const ScratchDirectory folder;
  {
    BagWriter bag(folder.path("angle.db3"));
    const int rows = bag.topic("/rows", "std_msgs/msg/Float64"), angle = bag.topic("/angle", "std_msgs/msg/Float64");
    for (int k = 0; k < 100; ++k) bag.message(rows, kStart + 10 * kMs * k, float64(k));
    for (const auto& [ms, value] : {std::pair{5, 3.0}, {25, -3.0}, {45, -2.9}, {65, -2.8}, {600, -2.8}})
      bag.message(angle, kStart + ms * kMs, float64(value));
  }
  const Recording log = read_recording(folder.path("angle.db3"), {"/rows", {{"/angle/data", true, 2.0 * M_PI}}});
  EXPECT_TRUE(std::isnan(log.numbers(0, 1)));
  EXPECT_NEAR(log.numbers(1, 1), 3.0 + 0.25 * (2.0 * M_PI - 6.0), 1e-12);
  EXPECT_NEAR(log.numbers(3, 1), -2.975, 1e-12);
  for (int k = 7; k < 60; ++k) EXPECT_TRUE(std::isnan(log.numbers(k, 1))) << k;
  EXPECT_EQ(log.numbers(60, 1), -2.8);
  EXPECT_TRUE(std::isnan(log.numbers(61, 1)));
}

TEST(Rosbag, ReadsTypesThatItHasTheDefinitionsOf) {
  const ScratchDirectory folder;
  {
    BagWriter bag(folder.path("own.db3"), true);
    const int own = bag.topic("/rig", "rig_msgs/msg/Rig");
    bag.run(
        "INSERT INTO message_definitions VALUES(1, 'rig_msgs/msg/Rig', 'ros2msg', 'std_msgs/Header header' || char(10) "
        "|| "
        "'float32 torque' || char(10) || '====' || char(10) || 'MSG: std_msgs/Header' || char(10) || "
        "'builtin_interfaces/Time stamp' || char(10) || 'string frame_id', '')");
    for (int k = 0; k < 3; ++k)
      bag.message(own, kStart + k, CdrWriter().header(kStart + 10 * k, "x").add(0.5F * static_cast<float>(k)).bytes());
  }
  EXPECT_EQ(read_recording(folder.path("own.db3"), {"/rig/header.stamp", {{"/rig/torque"}}}).numbers(2, 1), 1.0);
}

TEST(Rosbag, NamesFileTopicAndFixOfWhatCannotBeRead) {
  const ScratchDirectory folder;
  const std::string bag = rig_bag(folder);
  EXPECT_THAT(refusal(bag, {"", {{"/imu/dat/linear_acceleration.x"}}}),
              HasSubstr("rig.db3: no topic of \"/imu/dat/linear_acceleration.x\" among /imu/data, /truth, /command, "
                        "/rosout; did you mean /imu/data?"));
  EXPECT_THAT(refusal(bag, {"", {{"/imu/data/linear_accel.x"}}}), HasSubstr("did you mean \"linear_acceleration\"?"));
  EXPECT_THAT(refusal(bag, {"", {{"/imu/data"}}}), HasSubstr("/imu/data is a topic: name a number"));
  EXPECT_THAT(refusal(bag, {"", {{"/rosout/level"}}}),
              HasSubstr("type rcl_interfaces/msg/Log, whose definition is neither"));
  {
    BagWriter other(folder.path("json.db3"));
    other.topic("/a", "std_msgs/msg/Float64", "json");
  }
  EXPECT_THAT(refusal(folder.path("json.db3"), {"", {{"/a/data"}}}), HasSubstr("serialised as \"json\""));
  {
    BagWriter other(folder.path("short.db3"));
    other.message(other.topic("/a", "std_msgs/msg/Float64"), 1, float64(1.0).substr(0, 9));
    other.topic("/empty", "std_msgs/msg/Float64");
  }
  EXPECT_THAT(refusal(folder.path("short.db3"), {"", {{"/a/data"}}}),
              HasSubstr("short.db3: message 1 of /a ends after 9 bytes"));
  EXPECT_THAT(refusal(folder.path("short.db3"), {"/empty", {{"/a/data"}}}), HasSubstr("/empty has no messages"));
}

TEST(Rosbag, IsReadWholeOrRefusedWhereverItEnds) {
  const ScratchDirectory folder;
  const std::string whole = folder.read(std::filesystem::path(rig_bag(folder)).filename());
  const WantedColumns wanted{"/imu/data/header.stamp", {{"/imu/data/linear_acceleration.y"}, {"/command/data"}}};
  int refused = 0;
  for (std::size_t part = 0; part < 60; ++part) {
    const std::string cut = folder.write("cut.db3", whole.substr(0, whole.size() * part / 60));
    const std::string error = refusal(cut, wanted);
    EXPECT_THAT(error, HasSubstr("cut.db3: "));
    refused += error.empty() ? 0 : 1;
  }
  EXPECT_EQ(refused, 60);
  std::uint32_t random = 1;
  for (int i = 0; i < 300; ++i) {  // any byte may be wrong: no crash, no hang
    std::string spoilt = whole;
    for (int n = 0; n < 20; ++n) {
      random = random * 1664525U + 1013904223U;
      spoilt[(random >> 8) % spoilt.size()] = static_cast<char>(random >> 24);
    }
    refusal(folder.write("spoilt.db3", spoilt), wanted);
  }
}

TEST(Rosbag, IsTheDatasetThatTheCsvOfItsNumbersIs) {
  const ScratchDirectory folder;
  std::string csv = "t,y,x\n";
  {
    BagWriter bag(folder.path("log.db3"));
    const int imus = bag.topic("/imu", "sensor_msgs/msg/Imu");
    for (int k = 0; k < 200; ++k) {
      bag.message(imus, kStart + 10 * kMs * k + kMs, imu(kStart + 10 * kMs * k, std::round(1e3 * std::sin(0.1 * k))));
      csv += std::to_string(0.01 * k) + "," + std::to_string(std::round(1e3 * std::sin(0.1 * k))) + "," +
             std::to_string(-std::round(1e3 * std::sin(0.1 * k))) + "\n";
    }
  }
  folder.write("log.csv", csv);
  const auto config = [](const std::vector<std::string>& headings) {
    LogConfig log;
    log.sample_period_s = 0.01;
    const char* names[] = {"t", "y", "x"};
    const ColumnRole roles[] = {ColumnRole::kTime, ColumnRole::kOutput, ColumnRole::kState};
    for (std::size_t i = 0; i < 3; ++i) {
      ColumnConfig column;
      column.name = names[i];
      column.column = headings[i];
      column.role = roles[i];
      log.columns.push_back(column);
    }
    return log;
  };
  const Dataset from_bag =
      load_logs(config({"/imu/header.stamp", "/imu/linear_acceleration.x", "/imu/angular_velocity.x"}), folder.path(),
                {"log.db3"});
  const Dataset from_csv = load_logs(config({"t", "y", "x"}), folder.path(), {"log.csv"});
  ASSERT_EQ(from_bag.trajectories.size(), 1u);
  EXPECT_EQ(from_bag.trajectories[0].outputs, from_csv.trajectories[0].outputs);
  EXPECT_EQ(from_bag.trajectories[0].states, from_csv.trajectories[0].states);
  EXPECT_TRUE(from_bag.trajectories[0].time_s.isApprox(from_csv.trajectories[0].time_s, 1e-12));
}

TEST(Rosbag, IsLookedAtByNewLog) {
  const ScratchDirectory folder;
  const GuessedLog log = guess_log(
      {rig_bag(folder)}, {{"/truth/twist.linear.x"}, {"/imu/data/linear_acceleration.x"}, {"/command/data"}, 0.0});
  EXPECT_EQ(log.clock.heading, "/imu/data/header.stamp");
  EXPECT_NEAR(log.clock.period_s, 0.01, 1e-9);
  EXPECT_EQ(log.count(ColumnRole::kOutput), 1u);
  EXPECT_EQ(log.rows, 50);
  for (const GuessedColumn& column : log.columns) EXPECT_EQ(column.unit, "") << column.heading;
}

}  // namespace
}  // namespace nlo::trainer
