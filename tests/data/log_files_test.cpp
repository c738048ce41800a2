// SPDX-License-Identifier: MIT
#include "trainer/data/log_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "tests/data/data_testing.h"
#include "tests/support/thrown_message.h"

namespace nlo::trainer {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

LogConfig splits(std::vector<std::string> train, std::vector<std::string> validation, std::vector<std::string> test) {
  LogConfig config;
  config.train_files = std::move(train);
  config.validation_files = std::move(validation);
  config.test_files = std::move(test);
  return config;
}

TEST(LogFiles, ExpandsNamesAndGlobsInOrderWithoutDuplicates) {
  const ScratchDirectory scratch;
  for (const char* name : {"run2.csv", "run10.csv", "run1.csv", "other.csv"}) scratch.write(name, name);
  EXPECT_THAT(expand_files(scratch.path(), {"run*.csv", "run1.csv"}),
              ElementsAre(scratch.path("run1.csv"), scratch.path("run10.csv"), scratch.path("run2.csv")));
  EXPECT_THAT(expand_files(scratch.path(), {"run[1-9].csv"}),
              ElementsAre(scratch.path("run1.csv"), scratch.path("run2.csv")));
  EXPECT_THAT(expand_files("", {scratch.path("oth?r.csv")}), ElementsAre(scratch.path("other.csv")));
  EXPECT_THAT(expand_files(scratch.path(), {scratch.path("run1.csv")}), ElementsAre(scratch.path("run1.csv")));
}

TEST(LogFiles, PrefersExistingNamesWithGlobCharacters) {
  const ScratchDirectory scratch;
  scratch.write("day [1]/run*.csv", "x");
  scratch.write("day [1]/run2.csv", "y");
  const std::string day = scratch.path("day [1]");
  EXPECT_THAT(expand_files(day, {"run*.csv"}),
              ElementsAre(day + "/run*.csv"));  // a file of this name exists, so it is not a glob
  EXPECT_THAT(expand_files(day, {"run?.csv"}), ElementsAre(day + "/run*.csv", day + "/run2.csv"));
}

TEST(LogFiles, NamesPatternAndDirectoryIfNothingMatches) {
  const ScratchDirectory scratch;
  std::filesystem::create_directory(scratch.path("run1.csv"));  // a directory is not a log
  EXPECT_THAT(thrown_message([&] { expand_files(scratch.path(), {"run*.csv"}); }),
              AllOf(HasSubstr("no file matches \"run*.csv\""), HasSubstr(scratch.path())));
  EXPECT_THAT(thrown_message([&] { expand_files(scratch.path("nowhere"), {"a.csv"}); }),
              HasSubstr("no such directory"));
}

TEST(LogFiles, SplitsByFile) {
  const ScratchDirectory scratch;
  for (const char* name : {"run1.csv", "run2.csv", "run3.csv", "run4.csv"}) scratch.write(name, name);
  const SplitFiles files = expand_splits(splits({"run[12].csv"}, {"run3.csv"}, {"run4.csv"}), scratch.path());
  EXPECT_EQ(files.train.size(), 2u);
  EXPECT_THAT(files.validation, ElementsAre(scratch.path("run3.csv")));
  EXPECT_THAT(files.test, ElementsAre(scratch.path("run4.csv")));
  EXPECT_TRUE(expand_splits(splits({"run1.csv"}, {}, {}), scratch.path()).test.empty());
}

TEST(LogFiles, RefusesAFileOrItsCopyInTwoSplits) {
  const ScratchDirectory scratch;
  for (const char* name : {"run1.csv", "run2.csv"}) scratch.write(name, name);
  scratch.write("copy.csv", "run1.csv");
  const auto error_in = [&](const LogConfig& config) {
    return thrown_message([&] { expand_splits(config, scratch.path()); });
  };
  EXPECT_EQ(error_in(splits({"run1.csv"}, {}, {"run2.csv"})), "no error");  // control
  EXPECT_THAT(error_in(splits({"run*.csv"}, {}, {"run2.csv"})),
              HasSubstr("run2.csv: is in train_files and in test_files: list each log in only one split"));
  EXPECT_THAT(error_in(splits({"run1.csv"}, {"./run1.csv"}, {})), HasSubstr("in train_files and in validation_files"));
  EXPECT_THAT(error_in(splits({"run1.csv"}, {"copy.csv"}, {})),
              AllOf(HasSubstr("copy.csv: is in"), HasSubstr("with the same bytes")));
  EXPECT_THAT(error_in(splits({}, {"run1.csv"}, {})), HasSubstr("train_files names no file"));
}

TEST(LogFiles, HashDependsOnTheBytesAndNotOnTheNames) {
  const ScratchDirectory scratch;
  const std::string a = scratch.write("a.csv", "1,2\n"), b = scratch.write("b.csv", "1,2\n"),
                    c = scratch.write("c.csv", "1,3\n");
  EXPECT_EQ(content_hash({a}), content_hash({b}));
  EXPECT_NE(content_hash({a}), content_hash({c}));
  EXPECT_NE(content_hash({a, c}), content_hash({c, a}));
  EXPECT_EQ(content_hash({a}).size(), 16u);
  const std::string joined = scratch.write("joined.csv", "1,2\n1,3\n");
  EXPECT_NE(content_hash({a, c}), content_hash({joined}));
  EXPECT_EQ(content_hash({}), "cbf29ce484222325");  // the offset basis of FNV-1a
}

Dataset two_logs() {
  Dataset data;
  data.outputs = {{"y", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.inputs = {{"u", "", 0.0}};
  data.sample_period_s = 0.1;
  for (const int samples : {101, 31}) {
    Trajectory run;
    run.source = samples == 101 ? "long.csv" : "short.csv";
    run.time_s = Eigen::VectorXd::LinSpaced(samples, 0.0, 0.1 * (samples - 1)).array() + 7.0;
    run.outputs = run.time_s.transpose();
    run.states = 2.0 * run.time_s.transpose();
    run.inputs = 3.0 * run.time_s.transpose();
    run.weight = Eigen::VectorXd::LinSpaced(samples, 0.0, 1.0);
    run.first_estimate = 5;
    data.trajectories.push_back(run);
  }
  return data;
}

TEST(LogStarts, EachRunIsRepeatedFromEachStartWithinIt) {
  const Dataset logs = two_logs(), started = started_at(logs, {0.0, 0.3, 4.0});
  ASSERT_EQ(started.trajectories.size(), 5u) << "the short log ends after 3 s";
  EXPECT_EQ(started.trajectories[0].source, "long.csv");
  EXPECT_EQ(started.trajectories[0].samples(), 101);
  EXPECT_EQ(started.trajectories[0].first_estimate, 5);
  const Trajectory& run = started.trajectories[2];
  EXPECT_EQ(run.source.substr(0, 17), "long.csv from 0.3");
  ASSERT_EQ(run.samples(), 98);
  EXPECT_EQ(run.time_s(0), 0.0);
  EXPECT_NEAR(run.time_s(97), 9.7, 1e-12);
  EXPECT_EQ(run.outputs(0, 0), logs.trajectories[0].outputs(0, 3));
  EXPECT_EQ(run.states(0, 1), logs.trajectories[0].states(0, 4));
  EXPECT_EQ(run.inputs(0, 2), logs.trajectories[0].inputs(0, 5));
  EXPECT_EQ(run.weight(3), logs.trajectories[0].weight(6));
  EXPECT_EQ(run.first_estimate, 2);
  EXPECT_EQ(started.trajectories[4].samples(), 61);
}

TEST(LogStarts, RefusesAStartBeyondAllLogs) {
  EXPECT_THROW(started_at(two_logs(), {-1.0}), codegen::Error);
  EXPECT_THAT(thrown_message([&] {
                started_at(two_logs(), {0.0, 10.0});
              }),
              ::testing::HasSubstr("--from 10: the longest log ends after 10 s"));
}

}  // namespace
}  // namespace nlo::trainer
