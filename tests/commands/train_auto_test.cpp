// SPDX-License-Identifier: MIT
// nlo train --auto as a user runs it: it is interrupted and resumed, and the experiment that it finds also trains by
// itself.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

class TrainAuto : public testing::Test {
 protected:
  void SetUp() override { scratch.write("tiny.toml", kTinyExperiment); }

  json record(const std::string& folder) const { return json::parse(scratch.read(folder + "/auto.json")); }

  Scratch scratch;
};

TEST_F(TrainAuto, FindsAnExperimentThatTrainsToTheSameModel) {
  const ProgramResult result = scratch.ok({"train", "tiny.toml", "--auto", "--minutes", "0.1", "-o", "found"});
  EXPECT_THAT(result.out, AllOf(HasSubstr("unchanged"), HasSubstr("multiply-adds"), HasSubstr("found/auto.html"),
                                HasSubstr("found/model.json")));
  for (const char* file : {"auto.html", "auto.json", "experiment.toml", "model.json", "report.html", "finished.json"})
    EXPECT_TRUE(scratch.has(std::string("found/") + file)) << file;
  EXPECT_FALSE(scratch.has("found/auto/")) << "the trainings of the search leave no files";
  EXPECT_THAT(scratch.read("found/experiment.toml"),
              StartsWith("# Found by: nlo train tiny.toml --auto --minutes 0.1 -o found\n"));
  scratch.ok({"train", "found/experiment.toml", "-o", "again"});
  EXPECT_EQ(scratch.read("again/model.json"), scratch.read("found/model.json"));
  // The unchanged experiment was trained in full, together with the other candidates of the last rung.
  const json trials = record("found")["rungs"].back();
  EXPECT_EQ(trials[0]["candidate"], 0);
  EXPECT_EQ(trials[0]["steps"], 20);
  EXPECT_GT(trials.size(), 1U);
}

TEST_F(TrainAuto, ContinuesWhereItWasInterrupted) {
  scratch.write("tiny.toml", with(kTinyExperiment, "steps = 20", "steps = 2000"));
  const std::vector<std::string> arguments = {"train", "tiny.toml", "--auto", "--minutes", "0.3", "-o", "run"};
  const ProgramResult stopped = scratch.run(arguments, "rung ");
  EXPECT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("interrupted; to continue: nlo train tiny.toml --auto --minutes 0.3 -o run "
                                     "--resume"));
  EXPECT_FALSE(scratch.has("run/model.json"));
  const json before = record("run");

  std::vector<std::string> more = arguments;
  more.push_back("--resume");
  scratch.ok(more);
  const json after = record("run");
  ASSERT_EQ(after["candidates"].size(), before["candidates"].size());
  for (std::size_t c = 0; c < before["candidates"].size(); ++c)
    EXPECT_EQ(after["candidates"][c]["experiment"], before["candidates"][c]["experiment"]);
  for (std::size_t t = 0; t < before["rungs"][0].size(); ++t) {
    EXPECT_EQ(after["rungs"][0][t]["steps"], before["rungs"][0][t]["steps"]);
    if (before["rungs"][0][t]["done"]) {
      EXPECT_EQ(after["rungs"][0][t], before["rungs"][0][t]);
    }
  }
  // Everything is finished, so nothing is trained again.
  const std::string model = scratch.read("run/model.json");
  const ProgramResult again = scratch.ok(more);
  EXPECT_THAT(again.out, HasSubstr("already done"));
  EXPECT_EQ(scratch.read("run/model.json"), model);
  // Another budget starts another search.
  more[4] = "0.2";
  const ProgramResult other = scratch.run(more);
  EXPECT_NE(other.exit_code, 0);
  EXPECT_THAT(other.err, HasSubstr("belongs to another experiment, budget or data"));
}

TEST_F(TrainAuto, StaysWithinABudgetOfMultiplyAddsAndBytes) {
  const ProgramResult result = scratch.ok({"train", "tiny.toml", "--auto", "--minutes", "0.1", "--max-multiply-adds",
                                           "200", "--max-flash-bytes", "800", "-o", "small"});
  const json candidates = record("small")["candidates"];
  EXPECT_GT(candidates.size(), 1U);
  for (const json& candidate : candidates) {
    EXPECT_LE(candidate["multiply_adds"].get<int>(), 200);
    EXPECT_LE(candidate["flash_bytes"].get<int>(), 800);
  }
  // Control: without the budget, other candidates are drawn, which cost more.
  scratch.ok({"train", "tiny.toml", "--auto", "--minutes", "0.1", "-o", "any"});
  int most = 0;
  const json any = record("any")["candidates"];
  for (const json& candidate : any) most = std::max(most, candidate["multiply_adds"].get<int>());
  EXPECT_GT(most, 200);

  const ProgramResult none =
      scratch.run({"train", "tiny.toml", "--auto", "--minutes", "0.1", "--max-multiply-adds", "5", "-o", "none"});
  EXPECT_NE(none.exit_code, 0);
  EXPECT_THAT(none.err, HasSubstr("every candidate exceeds the budget --max-multiply-adds 5; allow more"));
  EXPECT_FALSE(scratch.has("none/"));
}

TEST_F(TrainAuto, ChoosesByLogsThatTrainingHasNotSeen) {
  scratch.write("tiny_log.toml", with(with(kTinyLogExperiment, "validation_files = [\"b.csv\"]\n", ""), "[\"a.csv\"]",
                                      "[\"log_?.csv\"]"));
  for (int i = 0; i < 5; ++i) scratch.write("logs/log_" + std::to_string(i) + ".csv", tiny_log(0.3 * i));
  const ProgramResult result =
      scratch.ok({"train", "tiny_log.toml", "--data", "logs", "--auto", "--minutes", "0.1", "-o", "run"});
  EXPECT_THAT(result.out, HasSubstr("the search chose by the training logs log_3.csv, which its trainings left out; "
                                    "the found experiment is trained on all logs."));
  EXPECT_THAT(scratch.read("run/experiment.toml"), HasSubstr("train_files = [\"log_?.csv\"]"));

  scratch.write("one.toml", with(with(kTinyLogExperiment, "validation_files = [\"b.csv\"]\n", ""), "[\"a.csv\"]",
                                 "[\"log_0.csv\"]"));
  const ProgramResult one = scratch.run({"train", "one.toml", "--data", "logs", "--auto", "-o", "one"});
  EXPECT_EQ(one.exit_code, 2);
  EXPECT_THAT(one.err, HasSubstr("name another one as validation_files in [log]"));
  EXPECT_FALSE(scratch.has("one/"));
}

TEST_F(TrainAuto, RefusesATimeThatIsTooShortAndKeepsExistingFiles) {
  scratch.ok({"train", "tiny.toml", "-o", "run"});
  scratch.write("tiny.toml", with(kTinyExperiment, "steps = 20", "steps = 50000000"));
  const auto before = scratch.contents();
  EXPECT_THAT(scratch.refusal(1, {"train", "tiny.toml", "--auto", "--minutes", "0.05", "-o", "run"}),
              AllOf(HasSubstr("--minutes 0.05 is too little"), HasSubstr("of the experiment's 50000000 steps"),
                    HasSubstr("or more"), Not(HasSubstr("--resume"))));
  EXPECT_EQ(scratch.contents(), before);
}

TEST_F(TrainAuto, OptionsOfAutoNeedAuto) {
  EXPECT_THAT(scratch.refusal(2, {"train", "tiny.toml", "--minutes", "1"}), HasSubstr("--auto"));
  EXPECT_THAT(scratch.refusal(2, {"train", "tiny.toml", "--auto", "--minutes", "nan"}),
              HasSubstr("nan is not a valid time for the search"));
}

TEST_F(TrainAuto, DoesNotReplaceTheModelOfAnotherExperiment) {
  scratch.ok({"train", "tiny.toml", "-o", "run"});
  scratch.write("other.toml", with(kTinyExperiment, "\"tiny\"", "\"other\""));
  const auto before = scratch.contents();
  const std::string result = scratch.refusal(2, {"train", "other.toml", "--auto", "--minutes", "0.1", "-o", "run"});
  EXPECT_EQ(scratch.contents(), before);
}

}  // namespace
}  // namespace nlo::trainer
