// SPDX-License-Identifier: MIT
#include "trainer/app/sweep/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <set>

#include "codegen/base/error.h"
#include "tests/support/thrown_message.h"
#include "trainer/app/sweep/sweep_jobs.h"
#include "trainer/base/printable.h"
#include "trainer/config/toml.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSubsetOf;
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

TEST(SweepPlan, HasEveryCombinationOfTheGrid) {
  EXPECT_THAT(texts(parse("[grid]\ntraining.steps = [1, 2]\ninverse_map.hidden = [[4], [8, 8]]\n")),
              ElementsAre("inverse_map.hidden=[4];training.steps=1;", "inverse_map.hidden=[8, 8];training.steps=1;",
                          "inverse_map.hidden=[4];training.steps=2;", "inverse_map.hidden=[8, 8];training.steps=2;"));
}

TEST(SweepPlan, AcceptsSectionsAndDottedKeys) {
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
  EXPECT_THAT(texts(parse(points)), SizeIs(2)) << "without a grid, only the points";
}

TEST(SweepPlan, WithoutKeysIsTheUnchangedExperiment) {
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

TEST(SweepPlan, ErrorsNameTheLineOfEachValue) {
  const SweepPlan plan = parse("[grid]\ntraining.steps = [\n  1,\n  2]\n");
  EXPECT_EQ(plan.points[0].front().place, "plan.toml:4");
  EXPECT_EQ(plan.points[1].front().place, "plan.toml:5");
}

TEST(SweepPlan, ReadsTheSettingsOfItsTest) {
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

TEST_P(RefusedPlan, NamesThePlaceAndTheRemedy) {
  const std::string message = thrown_message([&] { parse(GetParam().text); });
  EXPECT_THAT(message, HasSubstr(GetParam().message));
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
        Refusal{"UnevenZip", "[[zip]]\na = [1, 2]\nb = [1]\n", "plan.toml:4: [[zip]] b has 1 values, but a has 2"},
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
  EXPECT_THAT(thrown_message([&] { parse("seeds = [1, 2]\n[grid]\n" + axes); }),
              HasSubstr("plan.toml: 20000 jobs (100 x 100, 2 seeds); at most 10000 are allowed"));
  std::string many = "[grid]\n";  // 100^20 points: neither the points fit into memory nor their number into 64 bits
  for (int i = 0; i < 20; ++i) many += "k" + std::to_string(i) + " = [" + values + "]\n";
  EXPECT_THROW(parse(many), codegen::Error);
}

TEST(SweepPlan, NeedsAnExperiment) {
  EXPECT_THROW(parse_sweep_plan("seeds = [1]", "plan.toml"), codegen::Error);
}

std::vector<SweepJob> jobs(const std::string& text) {
  return jobs_of(parse_sweep_plan("experiment = \"tiny.toml\"\n" + text, "plan.toml"));
}

std::vector<std::string> names(const std::string& text) {
  std::vector<std::string> all;
  for (const SweepJob& job : jobs(text)) all.push_back(job.name);
  return all;
}

/// Returns `word` as a shell reads it.
std::string by_the_shell(const std::string& word) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(("printf %s " + word).c_str(), "r"), ::pclose);
  std::string text;
  for (int c = std::fgetc(pipe.get()); c != EOF; c = std::fgetc(pipe.get())) text += static_cast<char>(c);
  return text;
}

TEST(SweepJobs, KeepTheirFoldersIfThePlanIsExtended) {
  const auto before = names("seeds = [1, 2]\n[grid]\ninverse_map.hidden = [[8], [16, 16]]\ntraining.steps = [10]\n");
  const auto after = names(
      "seeds = [3, 2, 1]\n[grid]\ntraining.steps = [10, 20]\ninverse_map.hidden = [[16, 16], [4], [8]]\n"
      "[[point]]\ntraining.steps = 7\n");
  EXPECT_THAT(before, SizeIs(4));
  EXPECT_THAT(after, SizeIs(3 * 7));
  EXPECT_THAT(before, IsSubsetOf(after));
}

// Programs of a later version must find the folders of earlier sweeps, so this name must not change.
TEST(SweepJobs, KeepTheirNamesInLaterVersions) {
  EXPECT_EQ(names("seeds = [1]\n[grid]\ninverse_map.hidden = [[16, 16]]\n").front(), "hidden-16-16_seed-1_a3a612fb86");
}

TEST(SweepJobs, HaveUniqueNamesThatAnyFileSystemAccepts) {
  const std::string text = "seeds = [1, 2]\n[grid]\nplant.model = [\"a/../b\", \"a..b\", \"a b\", \"-\", \"\", \"" +
                           std::string(300, 'x') + "\", \"" + std::string(301, 'x') + "\"]\nx = [-1, 1, [1], [[1]]]\n";
  const auto all = names(text);
  EXPECT_THAT(std::set<std::string>(all.begin(), all.end()), SizeIs(2 * 7 * 4));
  for (const std::string& name : all) {
    EXPECT_LT(name.size(), 120U);
    EXPECT_EQ(name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.-"), std::string::npos) << name;
  }
}

TEST(SweepShards, HaveEveryJobOnce) {
  for (const std::size_t count : {1U, 2U, 3U, 7U, 20U}) {
    std::vector<int> times(17, 0);
    for (std::size_t index = 0; index < count; ++index) {
      const Shard shard = parse_shard(std::to_string(index) + "/" + std::to_string(count));
      std::size_t own = 0;
      for (std::size_t j = 0; j < times.size(); ++j)
        if (shard.has(j)) ++times[j], ++own;
      EXPECT_LE(own, times.size() / count + 1) << "sizes of shards differ by one job at most";
    }
    EXPECT_THAT(times, testing::Each(1)) << count << " shards";
  }
}

TEST(SweepShards, RefuseAnInvalidShard) {
  for (const char* text :
       {"", "3", "4/4", "-1/4", "0/0", "1/", "/4", "1/4x", "a/b", "99999999999999999999/4", "0 /4"}) {
    EXPECT_THAT(thrown_message([&] { parse_shard(text); }), HasSubstr("--shard 0/4 for the first of four"));
  }
}

TEST(SweepLines, ReachTheProgramUnchanged) {
  for (const std::string word : {"plain", "", "a b", "a'b", "$(false) `x` \"y\" \\ ; & | < > * ? ~ # !", "ü", "a\nb"})
    EXPECT_EQ(by_the_shell(shell_word(word)), word);
  EXPECT_EQ(shell_word("training.steps=3"), "training.steps=3") << "quoted only if necessary";
}

TEST(SweepLines, AreCompleteCommands) {
  const SweepJob job = jobs("seeds = [5]\n[grid]\na.b = [\"it's\"]\n").front();
  EXPECT_EQ(job_line(job, {"x y.toml", "logs", "runs/p", 1}),
            "nlo train 'x y.toml' --data logs --set 'a.b=\"it'\\''s\"' --seed 5 --threads 1 -o runs/p/" + job.name +
                " --resume -q");
  EXPECT_THROW(job_line(job, {"x\ny.toml", "", "runs/p", {}}), codegen::Error);
}

}  // namespace
}  // namespace nlo::trainer
