// SPDX-License-Identifier: MIT
// nlo crossvalidate leaves logs out of the training, one by one or in groups. nlo identify finds the parameters of a
// plant from logs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

class Crossvalidate : public testing::Test {
 protected:
  Crossvalidate() {
    scratch_.write("tiny.toml", with(kTinyLogExperiment, "train_files = [\"a.csv\"]\nvalidation_files = [\"b.csv\"]",
                                     "train_files = [\"day*.csv\"]"));
    double phase = 0.0;
    for (const char* name : {"day1_a.csv", "day1_b.csv", "day2_a.csv", "day2_b.csv"})
      scratch_.write(std::string("logs/") + name, tiny_log(phase += 0.7));
  }

  nlohmann::json run(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {"crossvalidate", "tiny.toml", "--data", "logs", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = scratch_.ok(arguments);
    return nlohmann::json::parse(result.out);
  }

  Scratch scratch_;
};

TEST_F(Crossvalidate, LeavesEachLogOutOnceAndTrainsOnTheOthers) {
  const auto before = scratch_.contents();
  const nlohmann::json outcomes = run({});
  ASSERT_EQ(outcomes.size(), 4u);
  for (const auto& outcome : outcomes) {
    EXPECT_EQ(outcome["training_logs"], 3);
    EXPECT_TRUE(std::isfinite(outcome["rmse"].front()["observer"].get<double>()));
  }
  EXPECT_EQ(outcomes[2]["left_out"], "day2_a.csv");
  EXPECT_EQ(scratch_.contents(), before) << "it writes nothing";
}

TEST_F(Crossvalidate, LeavesOutGroupsAndTrainsWithSeveralSeeds) {
  const nlohmann::json outcomes = run({"--group", "^(day[0-9])", "--seeds", "2"});
  ASSERT_EQ(outcomes.size(), 4u);
  EXPECT_EQ(outcomes[0]["left_out"], "day1");
  EXPECT_EQ(outcomes[0]["training_logs"], 2);
  EXPECT_NE(outcomes[0]["seed"], outcomes[1]["seed"]);
  const ProgramResult table =
      scratch_.run({"crossvalidate", "tiny.toml", "--data", "logs", "--group", "^(day[0-9])", "--seeds", "2"});
  EXPECT_THAT(table.out, HasSubstr("2 groups of logs left out one by one, 2 trainings of other seeds each"));
  EXPECT_THAT(table.out, HasSubstr("deviation over folds"));
}

TEST_F(Crossvalidate, ALearningCurveTrainsOnTheGivenNumbersOfLogs) {
  const nlohmann::json outcomes = run({"--logs", "1,3"});
  ASSERT_EQ(outcomes.size(), 8u);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(outcomes[i]["training_logs"], i < 4 ? 1 : 3);
  EXPECT_THAT(scratch_.run({"crossvalidate", "tiny.toml", "--data", "logs", "--logs", "1,3"}).out,
              HasSubstr("training logs"));
}

TEST_F(Crossvalidate, ContinuesAfterAnInterruptionToTheSameFigures) {
  scratch_.write("tiny.toml", with(scratch_.read("tiny.toml"), "steps = 20", "steps = 3000"));
  const std::vector<std::string> arguments = {"crossvalidate", "tiny.toml", "--data", "logs", "--threads", "1",
                                              "--json",        "-o",        "kept it"};
  const ProgramResult stopped = scratch_.run(arguments, "1/4 models");
  ASSERT_EQ(stopped.exit_code, 1) << stopped.err;
  EXPECT_THAT(stopped.err, HasSubstr("of 4 trainings left; to continue: nlo crossvalidate tiny.toml --data logs "
                                     "--json -o 'kept it'"));
  const auto before = scratch_.contents();
  const ProgramResult resumed = scratch_.ok(arguments);
  EXPECT_EQ(nlohmann::json::parse(resumed.out), run({}));
  int models = 0;
  for (const auto& [file, text] : before)
    if (file.ends_with("/finished.json")) {
      ++models;
      EXPECT_EQ(scratch_.read(file), text);
    }
  EXPECT_GE(models, 1);
  EXPECT_LT(models, 4) << "control: it was interrupted before its end";
  const auto after = scratch_.contents();
  EXPECT_EQ(scratch_.run(arguments).out, resumed.out);
  EXPECT_EQ(scratch_.contents(), after) << "nothing is trained again";
  // A changed log changes the data, so no training is reused.
  scratch_.write("logs/day1_a.csv", tiny_log(0.1));
  EXPECT_NE(scratch_.run(arguments).out, resumed.out);
  EXPECT_GT(scratch_.contents().size(), after.size());
}

/// Such patterns took hours before they were refused.
TEST_F(Crossvalidate, RefusesPatternsThatTakeTooLong) {
  for (const char* last : {"1.csv", "2.csv"}) scratch_.write("long/day" + std::string(100, 'a') + last, tiny_log());
  for (const char* pattern : {"^day(a+)+$", "^day(a|a)*$", "^day(a|aa)+$", "(a*)*b", "(.*a){20}x"}) {
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_THAT(scratch_.refusal(2, {"crossvalidate", "tiny.toml", "--data", "long", "--group", pattern}),
                HasSubstr("finds nothing in"))
        << pattern;
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20)) << pattern;
  }
}

TEST_F(Crossvalidate, RefusesFoldsWithoutTrainingLogsBeforeTraining) {
  const auto error = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"crossvalidate", "tiny.toml", "--data", "logs"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scratch_.refusal(2, arguments);
  };
  EXPECT_THAT(error({"--group", "^day"}), HasSubstr("needs at least two groups"));
  EXPECT_THAT(error({"--group", "night"}), HasSubstr("finds nothing in \"day1_a.csv\""));
  EXPECT_THAT(error({"--group", "("}), HasSubstr("is not a regular expression"));
  EXPECT_THAT(error({"--group", "(d)\\1"}), HasSubstr("has a back reference"));
  EXPECT_THAT(error({"--group", "(d{1,99}){1,99}"}), HasSubstr("the pattern is too large"));
  EXPECT_THAT(error({"--group", std::string(10000, '(')}), HasSubstr("the pattern is too large"));
  EXPECT_THAT(error({"--logs", "2,1,2"}), HasSubstr("--logs 2: is given twice"));
  EXPECT_THAT(error({"--logs", "4"}), HasSubstr("must be from 1 to 3"));
  scratch_.write("plant.toml", kTinyExperiment);
  EXPECT_THAT(scratch_.refusal(2, {"crossvalidate", "plant.toml"}), HasSubstr("use nlo evaluate"));
}

const std::string kPendulumFolder = NLO_SOURCE_DIR "/tests/data/pendulum";

class Identify : public testing::Test {
 protected:
  ProgramResult run(std::vector<std::string> more) const {
    std::vector<std::string> arguments = {
        "identify", kPendulumFolder + "/identify.toml", "--data", kPendulumFolder, "-o", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return scratch_.run(arguments);
  }

  Scratch scratch_;
};

TEST_F(Identify, FindsTheParametersAndItsFiltersBeatEstimatorsWithoutAPlant) {
  const ProgramResult result = run({"--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const auto said = nlohmann::json::parse(result.out);
  EXPECT_EQ(said, nlohmann::json::parse(scratch_.read("out/identified.json")));
  const auto score = [&](const char* name, double truth) {  // deviation in standard errors
    const auto& p = said["parameters"][name];
    return (p["value"].get<double>() - truth) / p["standard_error"].get<double>();
  };
  EXPECT_LT(std::abs(score("w2", 9.81 / 0.4)), 4.0);
  EXPECT_LT(std::abs(score("c", 0.3)), 4.0);
  EXPECT_GT(std::abs(score("c", 0.31)), 4.0) << "control: the errors are small";
  const auto rmse = [&](const char* estimator) {
    return said["estimators"][estimator]["rmse"]["rate"]["all"].get<double>();
  };
  for (const char* filter : {"ekf", "ukf"})
    for (const char* other : {"constant_acceleration", "static_ridge", "polynomial", "difference", "constant"})
      EXPECT_LT(rmse(filter), 0.7 * rmse(other)) << filter << " " << other;
}

TEST_F(Identify, PrintsTablesAndGivesTheSameFilesAgain) {
  const ProgramResult first = run({"--no-filters", "--threads", "1"});
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_THAT(first.out, HasSubstr("standard error"));
  EXPECT_THAT(first.out, HasSubstr("written: out/identified.json"));
  const std::string written = scratch_.read("out/identified.json");
  ASSERT_EQ(run({"--no-filters", "--threads", "3"}).exit_code, 0) << "it may replace its own result";
  EXPECT_EQ(scratch_.read("out/identified.json"), written);
}

TEST_F(Identify, WritesAnExperimentWithAPriorThatTrainsUnchanged) {
  const ProgramResult found = run({"--no-filters"});
  ASSERT_EQ(found.exit_code, 0) << found.err;
  EXPECT_THAT(found.out, HasSubstr("nlo train out/prior.toml --data " + kPendulumFolder));
  EXPECT_THAT(scratch_.read("out/prior.toml"), HasSubstr("structure = \"prior\""));
  scratch_.ok({"train", "out/prior.toml", "--data", kPendulumFolder, "-q", "-o", "trained"});
  const auto errors = nlohmann::json::parse(
      scratch_.run({"evaluate", "trained/model.json", "--data", kPendulumFolder + "/test.csv", "--json"}).out);
  const nlohmann::json& rate = errors.at(0).at("per_state").at(2);
  ASSERT_EQ(rate.at("name"), "rate") << "the state after sine and cosine of the angle";
  const auto observer = rate.at("rmse").at("all").get<double>();
  EXPECT_LT(observer, 0.7 * rate.at("against").at("polynomial").at("all").get<double>())
      << "a tuned Kalman filter is better";
}

TEST_F(Identify, KeepsAnExperimentThatAUserHasEdited) {
  scratch_.write("out/prior.toml", "# mine");
  const ProgramResult kept = run({"--no-filters"});
  EXPECT_EQ(kept.exit_code, 0) << kept.err;
  EXPECT_THAT(kept.out, HasSubstr("kept: out/prior.toml, because it has been changed; --force replaces it"));
  EXPECT_EQ(scratch_.read("out/prior.toml"), "# mine");
}

TEST_F(Identify, WritesAPriorThatStepsAStateWithoutAColumn) {
  const ProgramResult found =
      run({"--no-filters", "--set", "plant.states=[\"angle\", \"bend\", \"rate\"]", "--set",
           "plant.derivative=[\"rate\", \"-bend\", \"-w2 * sin(angle) - c * rate + bend\"]", "--set",
           "identify.initial_state=[0.0, 0.0, 0.0]", "--set", "identify.initial_deviation=[1.0, 0.1, 10.0]", "--set",
           "identify.process_noise=[0.001, 0.1, 0.1]"});
  ASSERT_EQ(found.exit_code, 0) << found.err;
  EXPECT_THAT(scratch_.read("out/prior.toml"), HasSubstr("estimated = [\"angle\", \"rate\"]"));
  scratch_.ok(
      {"train", "out/prior.toml", "--data", kPendulumFolder, "-q", "-o", "trained", "--set", "observer.units=0"});
  EXPECT_THAT(scratch_.read("trained/model.json"), HasSubstr("\"unestimated\": [\"bend\"]"));
}

TEST_F(Identify, SaysWhyAPlantHasNoObserverWithAPrior) {
  const auto reason = [&](std::vector<std::string> changes) {
    changes.insert(changes.begin(), "--no-filters");
    const ProgramResult result = run(changes);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_FALSE(scratch_.has("out/prior.toml"));
    return result.out;
  };
  // 1 - rate^2 / 400 is 0 within the range of the rate.
  EXPECT_THAT(reason({"--set", "plant.derivative=[\"rate\", \"-w2 * sin(angle) / (2 + cos(angle) - 1.1) - c * rate\"]",
                      "--set", "identify.iterations=1"}),
              HasSubstr("equations.derivative[2] has no bound"));
}

TEST_F(Identify, DoesNotReplaceFilesThatItDidNotWrite) {
  scratch_.write("out/identified.json", "{\"identification\": \"other\"}");
  const ProgramResult refused = run({"--no-filters"});
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("holds the result of another identification, other; choose another directory"));
  EXPECT_EQ(scratch_.read("out/identified.json"), "{\"identification\": \"other\"}");
  EXPECT_EQ(run({"--no-filters", "--force"}).exit_code, 0);
}

TEST_F(Identify, ErrorsNamePlaceAndRemedy) {
  const auto error = [&](const std::vector<std::string>& arguments) { return scratch_.refusal(2, arguments); };
  EXPECT_THAT(error({"identify", "qub"}), HasSubstr("did you mean \"qube\"?"));
  EXPECT_THAT(error({"identify"}), HasSubstr("IDENTIFICATION is required"));
  EXPECT_THAT(error({"identify", "qube", "--data", kPendulumFolder}), HasSubstr("example_csv_fin[1-6].csv"));
  EXPECT_THAT(run({"--set", "plant.parameters.w=1.0"}).err, HasSubstr("the parameter \"w\" has no effect"));
  scratch_.write("logs/train_1.csv", "time,angel,rate\n0,0,0\n0.1,0,0\n");
  scratch_.write("logs/test.csv", "time,angle,rate\n0,0,0\n0.1,0,0\n");
  EXPECT_THAT(error({"identify", kPendulumFolder + "/identify.toml", "--data", "logs"}),
              HasSubstr("no column \"angle\""));
  EXPECT_EQ(scratch_.run({"identify", "--help-config"}).exit_code, 0);
}

}  // namespace
}  // namespace nlo::trainer
