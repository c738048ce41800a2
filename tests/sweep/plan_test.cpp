// SPDX-License-Identifier: MIT
#include "trainer/sweep/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "trainer/config/toml.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

SweepPlan parse(const std::string& text) {
  return parse_sweep_plan("experiment = \"tiny.toml\"\n" + text, "plan.toml");
}

std::vector<std::string> texts(const SweepPlan& plan) {
  std::vector<std::string> all;
  for (const SweepPoint& point : plan.points) {
    std::string text;
    for (const SweepValue& value : point) text += value.key + "=" + value.value + ";";
    all.push_back(text);
  }
  return all;
}

TEST(SweepPlan, IsEveryCombinationOfTheGrid) {
  EXPECT_THAT(texts(parse("[grid]\ntraining.steps = [1, 2]\ninverse_map.hidden = [[4], [8, 8]]\n")),
              ElementsAre("inverse_map.hidden=[4];training.steps=1;", "inverse_map.hidden=[8, 8];training.steps=1;",
                          "inverse_map.hidden=[4];training.steps=2;", "inverse_map.hidden=[8, 8];training.steps=2;"));
}

TEST(SweepPlan, TakesSectionsAndDottedKeysAlike) {
  EXPECT_EQ(texts(parse("[grid.training]\nsteps = [1, 2]\n")), texts(parse("[grid]\ntraining.steps = [1, 2]\n")));
  EXPECT_EQ(texts(parse("[grid]\n\"training.steps\" = [1, 2]\n")), texts(parse("[grid]\ntraining.steps = [1, 2]\n")));
}

TEST(SweepPlan, ChangesZippedKeysTogether) {
  EXPECT_THAT(texts(parse("[grid]\na = [1, 2]\n[[zip]]\nb = [3, 4]\nc = [5, 6]\n")),
              ElementsAre("a=1;b=3;c=5;", "a=1;b=4;c=6;", "a=2;b=3;c=5;", "a=2;b=4;c=6;"));
}

TEST(SweepPlan, AddsPointsBesideTheGrid) {
  const std::string points = "[[point]]\ntraining.steps = 7\nplant.parameters = { mu = 1.5 }\n[[point]]\n";
  EXPECT_THAT(texts(parse("[grid]\ntraining.steps = [1]\n" + points)),
              ElementsAre("training.steps=1;", "plant.parameters.mu=1.5;training.steps=7;", ""));
  EXPECT_THAT(texts(parse(points)), SizeIs(2)) << "without a grid, the points alone";
}

TEST(SweepPlan, OfNothingIsTheExperimentAsItStands) {
  EXPECT_THAT(texts(parse("seeds = [1, 2]\n")), ElementsAre(""));
}

TEST(SweepPlan, WritesValuesThatReadBackTheSame) {
  const std::string values =
      "[1, -2.5, 1e-3, 4.0, true, \"a \\\"b\\\" \\\\ \\n ü\", [[1, 2], []], { mu = [0.5, 2], \"k\" = \"v\" }, inf]";
  const Toml written = parse_toml("v = " + values, "x");
  const SweepPlan plan = parse("[grid]\nv = " + values);
  ASSERT_THAT(plan.points, SizeIs(9));
  for (std::size_t i = 0; i < plan.points.size(); ++i) {
    Toml root(Toml::table_type{});
    apply_override(root, "v=" + plan.points[i].front().value);
    EXPECT_TRUE(root.as_table().at("v") == written.as_table().at("v").as_array()[i])
        << plan.points[i].front().value;  // type and value
  }
}

TEST(SweepPlan, KnowsTheLineOfEachValue) {
  const SweepPlan plan = parse("[grid]\ntraining.steps = [\n  1,\n  2]\n");
  EXPECT_EQ(plan.points[0].front().place, "plan.toml:4");
  EXPECT_EQ(plan.points[1].front().place, "plan.toml:5");
}

TEST(SweepPlan, ReadsItsTest) {
  const SweepPlan plan = parse("data = \"logs\"\n[test]\nnoise = \"gaussian:0.5\"\nseed = 3\ntrajectories = 20\n");
  EXPECT_EQ(plan.data, "logs");
  ASSERT_TRUE(plan.test.noise.has_value());
  EXPECT_EQ(plan.test.noise->of(0).scale, 0.5);
  EXPECT_EQ(plan.test.seed, 3U);
  EXPECT_EQ(plan.test.trajectories, 20);
  EXPECT_FALSE(parse("").test.noise.has_value());
}

struct Refusal {
  std::string name, text, message;
};

class RefusedPlan : public testing::TestWithParam<Refusal> {};

TEST_P(RefusedPlan, SaysWhereAndWhatToDo) {
  try {
    parse(GetParam().text);
    FAIL() << "no error";
  } catch (const codegen::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr(GetParam().message));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Plans, RefusedPlan,
    testing::Values(
        Refusal{"UnknownKey", "sedes = [1]", "plan.toml:2: unknown key \"sedes\" in a plan; did you mean \"seeds\"?"},
        Refusal{"TestKeyAbove", "trajectories = 3", "it belongs in [test]"},
        Refusal{"NoList", "[grid]\ntraining.steps = 3",
                "plan.toml:3: [grid] training.steps is an integer; it must be a list of the values to try: "
                "training.steps = [3]"},
        Refusal{"NoValues", "[grid]\ntraining.steps = []", "plan.toml:3: [grid] training.steps has no values"},
        Refusal{"Date", "[grid]\ntraining.steps = [2026-01-01]", "plan.toml:3: a date or time is not a value"},
        Refusal{"NoKey", "[grid]\n\"a b\" = [1]", "plan.toml:3: \"a b\" is not a key of an experiment"},
        Refusal{"SeedInTheGrid", "[grid]\nseed = [1]", "plan.toml:3: the seed is varied by seeds = [1, 2, 3]"},
        Refusal{"SeedTwice", "seeds = [1, 2, 1]", "plan.toml:2: seeds has 1 twice"},
        Refusal{"KeyTwice", "[grid]\na.b = [1, 2]\n[[zip]]\na.b = [1]\n",
                "plan.toml:5: a.b is varied already, in plan.toml:3"},
        Refusal{"UnevenZip", "[[zip]]\na = [1, 2]\nb = [1]\n", "plan.toml:4: [[zip]] b has 1 values and a has 2"},
        Refusal{"EmptyZip", "[[zip]]\n", "[[zip]] has no keys"},
        Refusal{"GridIsNoSection", "grid = 3", "it must be a section: [grid]"},
        Refusal{"PointIsNoTable", "point = [3]", "plan.toml:2: point is an integer; each one is a table"},
        Refusal{"TestNoise", "[test]\nnoise = \"gausian:1\"", "plan.toml:3: "}),
    [](const auto& refused) { return refused.param.name; });

TEST(SweepPlan, HasALimitOfJobs) {
  std::string values;
  for (int i = 0; i < 100; ++i) values += std::to_string(i) + ",";
  const std::string axes = "a = [" + values + "]\nb = [" + values + "]\n";
  EXPECT_THAT(parse("[grid]\n" + axes).points, SizeIs(kMostSweepJobs));
  try {
    parse("seeds = [1, 2]\n[grid]\n" + axes);
    FAIL() << "no error";
  } catch (const codegen::Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("plan.toml: 20000 jobs (100 x 100, 2 seeds); 10000 are the most"));
  }
  std::string many = "[grid]\n";  // 100^20 points would not fit into any memory, nor their number into 64 bits
  for (int i = 0; i < 20; ++i) many += "k" + std::to_string(i) + " = [" + values + "]\n";
  EXPECT_THROW(parse(many), codegen::Error);
}

TEST(SweepPlan, NeedsAnExperiment) {
  EXPECT_THROW(parse_sweep_plan("seeds = [1]", "plan.toml"), codegen::Error);
}

}  // namespace
}  // namespace nlo::trainer
