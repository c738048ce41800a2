// SPDX-License-Identifier: MIT
// nlo monitor as a user gives it: on a plant, on logs, again, and in the header that is exported.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(MonitorCommand, GivesTheModelWhatItsHeaderThenHas) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "run", "-q"}).exit_code, 0);
  const std::string before = scratch.read("run/model.json");
  const auto watched = scratch.run(
      {"monitor", "run/model.json", "--quick", "--hours", "0.05", "--runs", "3", "-o", "new.json", "--json"});
  ASSERT_EQ(watched.exit_code, 0) << watched.err;
  EXPECT_EQ(scratch.read("run/model.json"), before);
  const auto json = nlohmann::json::parse(watched.out);
  EXPECT_EQ(json["runs"], 3);
  EXPECT_EQ(json["conditions"]["as_trained"]["ratio"], 1.0);
  EXPECT_TRUE(json["conditions"].contains("parameters_high"));
  ASSERT_EQ(scratch.run({"export", "new.json", "-o", "tiny.h"}).exit_code, 0);
  EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("kMonitor"));
  // C99 has no monitor: that is said to who is told nothing else, too.
  const auto c99 = scratch.run({"export", "new.json", "--target", "c99", "-q", "-o", "firmware/tiny.h"});
  EXPECT_EQ(c99.exit_code, 0) << c99.err;
  EXPECT_THAT(c99.err, testing::StartsWith("warning: the model's monitor is left out: target c99 has none"));
  EXPECT_EQ(c99.out, "");
  EXPECT_TRUE(scratch.has("firmware/tiny.c"));
  EXPECT_EQ(scratch.run({"export", "new.json", "-q", "-o", "tiny.h"}).err, "");
  // Made again from a model that has one it is the same.
  ASSERT_EQ(scratch.run({"monitor", "new.json", "--hours", "0.05", "--runs", "0", "--threads", "3"}).exit_code, 0);
  const auto again = scratch.run({"monitor", "run/model.json", "--hours", "0.05", "--runs", "0", "--threads", "1"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.out, Not(HasSubstr("condition")));
  EXPECT_EQ(scratch.read("new.json"), scratch.read("run/model.json"));
}

TEST(MonitorCommand, OfALogModelIsMadeFromItsLogs) {
  const Scratch scratch;
  scratch.write("log.toml", kTinyLogExperiment);
  scratch.write("a.csv", tiny_log(0.0, 3000));
  scratch.write("b.csv", tiny_log(1.0, 3000));
  ASSERT_EQ(scratch.run({"train", "log.toml", "--data", ".", "-o", "run", "-q"}).exit_code, 0);
  const auto watched = scratch.run({"monitor", "run/model.json", "--data", ".", "--time-constant", "0.2"});
  ASSERT_EQ(watched.exit_code, 0) << watched.err;
  EXPECT_THAT(watched.out, HasSubstr("limits for 1.00 false alarms an hour"));
  EXPECT_THAT(scratch.read("run/model.json"), HasSubstr("\"monitor\""));
  const auto too_long = scratch.run({"monitor", "run/model.json", "--data", ".", "--time-constant", "100"});
  EXPECT_EQ(too_long.exit_code, 1);
  EXPECT_THAT(too_long.err, HasSubstr("or a shorter --time-constant"));
}

}  // namespace
}  // namespace nlo::trainer
