// SPDX-License-Identifier: MIT
// Experiments that leave out what a recipe derives, as a user would give them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string draft() {
  return with(kTinyExperiment, "eigenvalues = [-1.0, -2.0, -3.0]\n", "");
}

TEST(DraftProgram, TrainsToTheBytesOfWhatItDerived) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  const auto train = scratch.run({"train", "draft.toml", "-o", "a"});
  ASSERT_EQ(train.exit_code, 0) << train.err;
  EXPECT_THAT(train.err, HasSubstr("derived  eigenvalues"));
  EXPECT_THAT(scratch.read("a/derived.toml"), AllOf(HasSubstr("hidden = [8]"), HasSubstr("steps = 20")));
  const auto again = scratch.run({"train", "a/derived.toml", "-o", "b"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_THAT(again.err, Not(HasSubstr("derived  eigenvalues")));
  EXPECT_TRUE(scratch.read("a/model.json") == scratch.read("b/model.json"));
  EXPECT_FALSE(scratch.has("b/derived.toml"));
}

TEST(DraftProgram, ResumesToTheSameBytes) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  ASSERT_EQ(scratch.run({"train", "draft.toml", "-o", "a", "-q"}).exit_code, 0);
  const std::string model = scratch.read("a/model.json");
  EXPECT_THAT(scratch.run({"train", "draft.toml", "-o", "a", "--resume"}).out, HasSubstr("already done"));
  std::filesystem::remove(scratch.path() + "/a/finished.json");
  const auto resumed = scratch.run({"train", "draft.toml", "-o", "a", "--resume"});
  ASSERT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_TRUE(scratch.read("a/model.json") == model);
}

TEST(DraftProgram, IsQuietWhenAsked) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  EXPECT_EQ(scratch.run({"train", "draft.toml", "-q"}).err, "");
}

TEST(DraftProgram, SimulatesWithoutAnObserver) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  EXPECT_EQ(scratch.run({"simulate", "draft.toml", "-o", "run.csv"}).exit_code, 0);
  EXPECT_TRUE(scratch.has("run.csv"));
}

TEST(DraftProgram, DerivesFromLogs) {
  const Scratch scratch;
  scratch.write("draft.toml", kTinyLogExperiment.substr(0, kTinyLogExperiment.find("[observer]")));
  double phase = 0.0;
  for (const char* file : {"a.csv", "b.csv", "c.csv"}) scratch.write(std::string("logs/") + file, tiny_log(phase++));
  const auto train = scratch.run({"train", "draft.toml", "--data", "logs", "--set", "training.steps=20", "-o", "r"});
  EXPECT_NE(train.exit_code, 2) << train.err;  // 1: so few steps need not gain anything
  EXPECT_THAT(scratch.read("r/derived.toml"), AllOf(HasSubstr("learn_eigenvalues = false"), HasSubstr("clocks_s = [")));
}

}  // namespace
}  // namespace nlo::trainer
