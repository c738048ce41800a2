// SPDX-License-Identifier: MIT
#include "trainer/data/log_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/data/testing.h"

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

TEST(LogFiles, ExpandsNamesAndGlobsSortedAndOnce) {
  const ScratchDirectory scratch;
  for (const char* name : {"run2.csv", "run10.csv", "run1.csv", "other.csv"}) scratch.write(name, name);
  EXPECT_THAT(expand_files(scratch.path(), {"run*.csv", "run1.csv"}),
              ElementsAre(scratch.file("run1.csv"), scratch.file("run10.csv"), scratch.file("run2.csv")));
  EXPECT_THAT(expand_files(scratch.path(), {"run[1-9].csv"}),
              ElementsAre(scratch.file("run1.csv"), scratch.file("run2.csv")));
  EXPECT_THAT(expand_files("", {scratch.file("oth?r.csv")}), ElementsAre(scratch.file("other.csv")));
  EXPECT_THAT(expand_files(scratch.path(), {scratch.file("run1.csv")}), ElementsAre(scratch.file("run1.csv")));
}

TEST(LogFiles, TakesNamesWithGlobCharactersLiterally) {
  const ScratchDirectory scratch;
  scratch.write("day [1]/run*.csv", "x");
  scratch.write("day [1]/run2.csv", "y");
  const std::string day = scratch.file("day [1]");
  EXPECT_THAT(expand_files(day, {"run*.csv"}), ElementsAre(day + "/run*.csv"));  // it is there: no glob
  EXPECT_THAT(expand_files(day, {"run?.csv"}), ElementsAre(day + "/run*.csv", day + "/run2.csv"));
}

TEST(LogFiles, NamesPatternAndDirectoryWhenNothingMatches) {
  const ScratchDirectory scratch;
  std::filesystem::create_directory(scratch.file("run1.csv"));  // a directory is no log
  EXPECT_THAT(error_of([&] { expand_files(scratch.path(), {"run*.csv"}); }),
              AllOf(HasSubstr("no file matches \"run*.csv\""), HasSubstr(scratch.path())));
  EXPECT_THAT(error_of([&] { expand_files(scratch.file("nowhere"), {"a.csv"}); }), HasSubstr("no such directory"));
}

TEST(LogFiles, SplitsByFile) {
  const ScratchDirectory scratch;
  for (const char* name : {"run1.csv", "run2.csv", "run3.csv", "run4.csv"}) scratch.write(name, name);
  const SplitFiles files = expand_splits(splits({"run[12].csv"}, {"run3.csv"}, {"run4.csv"}), scratch.path());
  EXPECT_EQ(files.train.size(), 2u);
  EXPECT_THAT(files.validation, ElementsAre(scratch.file("run3.csv")));
  EXPECT_THAT(files.test, ElementsAre(scratch.file("run4.csv")));
  EXPECT_TRUE(expand_splits(splits({"run1.csv"}, {}, {}), scratch.path()).test.empty());
}

TEST(LogFiles, RefusesAFileOrItsCopyInTwoSplits) {
  const ScratchDirectory scratch;
  for (const char* name : {"run1.csv", "run2.csv"}) scratch.write(name, name);
  scratch.write("copy.csv", "run1.csv");
  const auto error_in = [&](const LogConfig& config) {
    return error_of([&] { expand_splits(config, scratch.path()); });
  };
  EXPECT_EQ(error_in(splits({"run1.csv"}, {}, {"run2.csv"})), "");  // control
  EXPECT_THAT(error_in(splits({"run*.csv"}, {}, {"run2.csv"})),
              HasSubstr("run2.csv: is in train_files and in test_files: a log belongs to one split"));
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

}  // namespace
}  // namespace nlo::trainer
