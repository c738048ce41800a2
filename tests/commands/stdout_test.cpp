// SPDX-License-Identifier: MIT
// `-o -`: a command that writes one file writes it to stdout, and nothing else goes there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

class Stdout : public testing::Test {
 protected:
  Stdout() {
    scratch_.write("tiny.toml", kTinyExperiment);
    EXPECT_EQ(scratch_.run({"train", "tiny.toml", "-o", "run", "-q", "--set", "training.steps=3"}).exit_code, 0);
  }
  /// The same file by its name and by stdout.
  void expect_same(std::vector<std::string> command, const std::string& file) {
    command.insert(command.end(), {"-o", file});
    ASSERT_EQ(scratch_.run(command).exit_code, 0);
    command.back() = "-";
    const auto before = scratch_.contents();
    const auto streamed = scratch_.run(command);
    EXPECT_EQ(streamed.exit_code, 0) << streamed.err;
    EXPECT_FALSE(streamed.out.empty());
    EXPECT_TRUE(streamed.out == scratch_.read(file));
    EXPECT_EQ(scratch_.contents(), before) << "a file was left behind";
  }
  void expect_refused(const std::vector<std::string>& command, const std::string& why) {
    const auto refused = scratch_.run(command);
    EXPECT_EQ(refused.exit_code, 2) << refused.out;
    EXPECT_THAT(refused.err, AllOf(HasSubstr("-o -: "), HasSubstr(why)));
    EXPECT_EQ(refused.out, "");
    EXPECT_FALSE(scratch_.has("-") || scratch_.has("-/"));
  }
  Scratch scratch_;
};

TEST_F(Stdout, HasTheFileOfEachCommandThatWritesOne) {
  expect_same({"simulate", "tiny.toml", "--noise", "gaussian:0.1"}, "run.csv");
  expect_same({"report", "run", "--noise", "none"}, "report.html");
  expect_same({"export", "run/model.json", "-q"}, "tiny.h");
}

TEST_F(Stdout, IsRefusedWhereACommandWritesSeveralFiles) {
  expect_refused({"simulate", "tiny.toml", "--trajectories", "2", "-o", "-"}, "2 trajectories");
  expect_refused({"train", "tiny.toml", "-q", "-o", "-"}, "a folder of files");
  expect_refused({"reproduce", "table1", "--quick", "-o", "-"}, "a folder of files");
  expect_refused({"bound", "run/model.json", "-o", "-"}, "two files");
  expect_refused({"export", "run/model.json", "--target", "c99", "-o", "-"}, "several files");
}

TEST_F(Stdout, HasTheBoundAsCsv) {
  const auto bound =
      scratch_.run({"bound", "run/model.json", "--k", "1", "--trajectories", "4", "--csv", "-q", "-o", "bound"});
  ASSERT_EQ(bound.exit_code, 0) << bound.err;
  EXPECT_TRUE(bound.out == scratch_.read("bound/bound.csv"));
  EXPECT_EQ(scratch_.run({"bound", "run/model.json", "--csv", "--json"}).exit_code, 2);
}

TEST(SeveralNoises, AreOneForEachOutput) {
  const Scratch scratch;
  const std::string two = with(kTinyExperiment, "model = \"van_der_pol\"",
                               "states = [\"x1\", \"x2\"]\nderivative = [\"x2\", \"-x1\"]\noutputs = [\"x1\", \"x2\"]");
  scratch.write("two.toml", with(two, "\"gaussian:0.1\"", "[\"gaussian:0.1\", \"none\"]"));
  const auto train = scratch.run({"train", "two.toml", "-o", "run", "-q"});
  ASSERT_EQ(train.exit_code, 0) << train.err;
  EXPECT_THAT(train.out, HasSubstr("noise gaussian:0.1,none"));
  EXPECT_THAT(scratch.read("run/report.html"), HasSubstr("N(0, 0.1), no noise"));
  const auto json = scratch.run({"evaluate", "run/model.json", "--noise", "gaussian:0.1,uniform:0.02", "--json",
                                 "--trajectories", "3", "--against", "ekf"});
  ASSERT_EQ(json.exit_code, 0) << json.err;
  EXPECT_THAT(json.out, HasSubstr("gaussian:0.1,uniform:0.02"));
  for (const std::vector<std::string>& command : {std::vector<std::string>{"evaluate", "run/model.json"},
                                                  {"report", "run"},
                                                  {"simulate", "two.toml", "-o", "-"}}) {
    std::vector<std::string> wrong = command;
    wrong.insert(wrong.end(), {"--noise", "none,none,none"});
    const auto refused = scratch.run(wrong);
    EXPECT_EQ(refused.exit_code, 2) << command.front();
    EXPECT_THAT(refused.err, HasSubstr("is of 3 outputs, but there are 2"));
  }
  const auto csv = scratch.run({"simulate", "two.toml", "--noise", "none,uniform:1", "-o", "-"});
  EXPECT_THAT(csv.out, StartsWith("trajectory,time,y1,y2,y1_measured,y2_measured,x1,x2\n"));
  EXPECT_THAT(csv.out, EndsWith("\n"));
}

}  // namespace
}  // namespace nlo::trainer
