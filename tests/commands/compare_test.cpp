// SPDX-License-Identifier: MIT
// nlo evaluate --conditions, run as a user does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using Json = nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

const std::string kConditions =
    "[[condition]]\nname = \"noise\"\nnoise = \"gaussian:0.5\"\n"
    "[[condition]]\nname = \"wrong\"\nnoise = \"gaussian:0.5+outliers:0.1:5\"\nparameters = { mu = 1.2 }\n";

class CompareCommand : public testing::Test {
 protected:
  void SetUp() override {
    scratch.write("tiny.toml", kTinyExperiment);
    scratch.ok({"train", "tiny.toml", "-o", "run", "-q"});
    scratch.write("mine.toml", kConditions);
  }

  Json figures(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"evaluate",       "run/model.json",
                                          "--conditions",   "mine.toml",
                                          "--seeds",        "2",
                                          "--trajectories", "3",
                                          "--tuning-runs",  "2",
                                          "--particles",    "50",
                                          "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = scratch.ok(arguments);
    return Json::parse(result.out);
  }

  Scratch scratch;
};

TEST_F(CompareCommand, GivesTheSameFiguresForAnyNumberOfThreads) {
  const Json one = figures({"--threads", "1"});
  EXPECT_EQ(one, figures({"--threads", "3"}));
  EXPECT_NE(one, figures({"--threads", "1", "--seed", "2"})) << "control: the figures depend on the seed";
  EXPECT_EQ(one["conditions"].size(), 2u);
  for (const auto& condition : one["conditions"])
    for (const char* name : {"observer", "ekf", "ekf_tuned", "ukf", "joint_ekf", "mhe_tuned", "high_gain", "particle"})
      EXPECT_TRUE(condition["columns"][name]["norm"].is_number()) << name;
  EXPECT_LE(one["conditions"]["wrong"]["columns"]["particle"]["worst"]["seed"], 2);
}

TEST_F(CompareCommand, TestsOnTheSameRunsAsEvaluate) {
  const std::string all = "ekf,ukf,static_ridge,constant,ridge";
  double before = 0.0;
  for (const std::vector<std::string>& changed :
       {std::vector<std::string>{}, {"--set", "plant.parameters.mu=1.3", "--set", "simulation.horizon_s=2"}}) {
    std::vector<std::string> compare = {"--against", all, "--no-tuning"};
    std::vector<std::string> evaluate = {"evaluate", "run/model.json", "--noise", "gaussian:0.5", "--seeds",
                                         "2",        "--trajectories", "3",       "--against",    all,
                                         "--json"};
    compare.insert(compare.end(), changed.begin(), changed.end());
    evaluate.insert(evaluate.end(), changed.begin(), changed.end());
    const ProgramResult evaluated = scratch.ok(evaluate);
    const Json evaluation = Json::parse(evaluated.out)[0], columns = figures(compare)["conditions"]["noise"]["columns"];
    EXPECT_NEAR(columns["observer"]["norm"], evaluation["norm"], 1e-9);
    // Both commands have their own implementation of these filters, so results differ by rounding and by the step of
    // the finite differences.
    const auto norm = [&](const char* name) { return evaluation["against"][name]["norm"].get<double>(); };
    for (const char* filter : {"ekf", "ukf"}) EXPECT_NEAR(columns[filter]["norm"], norm(filter), 1e-5) << filter;
    for (const char* simple : {"static_ridge", "constant", "ridge"})
      EXPECT_NEAR(columns[simple]["norm"], norm(simple), 1e-9) << simple;
    EXPECT_GT(std::abs(norm("ekf") - norm("ukf")), 1e-4) << "control: the two filters differ";
    EXPECT_NE(norm("ekf"), before) << "control: --set changes the runs";
    before = norm("ekf");
    EXPECT_FALSE(columns.contains("ekf_tuned"));
  }
}

TEST_F(CompareCommand, WritesASelfContainedPage) {
  const ProgramResult result = scratch.ok({"evaluate", "run/model.json", "--conditions", "mine.toml", "--quick",
                                           "--against", "ekf,high_gain", "--trajectories", "2", "-o", "out"});
  EXPECT_THAT(result.out, HasSubstr("observer"));
  EXPECT_THAT(result.out, HasSubstr("The worst run of each"));
  EXPECT_THAT(result.out, HasSubstr("report   out/compare.html"));
  const std::string page = scratch.read("out/compare.html");
  EXPECT_THAT(page, StartsWith("<!DOCTYPE html>"));
  EXPECT_THAT(page, HasSubstr("EKF, tuned"));
  EXPECT_THAT(page, HasSubstr("N(0, 0.5) + 10 % outliers to 5, mu = 1.2"));
  for (const char* outside : {"src=", "<script", "<link", "@import", "url("})
    EXPECT_THAT(page, Not(HasSubstr(outside))) << "the page must not need a network";
  EXPECT_TRUE(Json::parse(scratch.read("out/compare.json"))["conditions"].contains("wrong"));
}

TEST_F(CompareCommand, RefusesModelsThatItCannotCompareBeforeItRunsThem) {
  scratch.write("bad.toml", "[[condition]]\nname = \"a\"\nparameters = { mi = 2 }\n");
  const auto refusal = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"evaluate", "run/model.json", "-o", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const std::string result = scratch.refusal(2, arguments);
    EXPECT_FALSE(scratch.has("out"));
    return result;
  };
  EXPECT_THAT(refusal({"--conditions", "bad.toml"}),
              HasSubstr("bad.toml:1: condition \"a\" changes the parameter \"mi\""));
  EXPECT_THAT(refusal({"--conditions", "nowhere.toml"}), HasSubstr("nowhere.toml"));
  EXPECT_THAT(refusal({"--as-trained", "--set", "observer.gain=2"}),
              HasSubstr("--set observer.gain=2: a test can only change plant.KEY"));
  scratch.write("far.toml", "[[condition]]\nname = \"a\"\nset = [\"plant.parameters.mi=2\"]\n");
  EXPECT_THAT(refusal({"--conditions", "far.toml"}), AllOf(HasSubstr("far.toml:1: condition \"a\""),
                                                           HasSubstr("has no parameter \"mi\"; did you mean \"mu\"")));
  EXPECT_THAT(refusal({"--as-trained", "--against", "ekv"}), HasSubstr("ekv"));
  EXPECT_THAT(refusal({"--conditions", "mine.toml", "--seeds", "0"}), HasSubstr("--seeds"));
  EXPECT_THAT(refusal({"--conditions", "mine.toml", "--noise", "none"}), HasSubstr("--conditions excludes --noise"));
  EXPECT_THAT(refusal({"--conditions", "mine.toml", "--against", "ekf_true"}),
              HasSubstr("ekf_true cannot be used with --cond"));
  EXPECT_THAT(refusal({"--quick"}), HasSubstr("needs a test under conditions; add --conditions FILE"));
  EXPECT_THAT(scratch.refusal(2, {"evaluate", "run/model.json", "--against", "particle"}),
              HasSubstr("--against particle needs conditions"));
  scratch.write("other.toml", with(kTinyExperiment, "van_der_pol", "harmonic_oscillator"));
  scratch.ok({"train", "other.toml", "-o", "other", "-q"});
  EXPECT_THAT(refusal({"--as-trained", "other/model.json"}),
              HasSubstr("other/model.json: has another plant than run/model.json"));
}

TEST_F(CompareCommand, LeavesOutAConditionThatDoesNotFitThePlantOnlyInTheDefaultSet) {
  const std::string both = "[[condition]]\nname = \"near\"\n[[condition]]\nname = \"far\"\nbox_scale = 1e6\n";
  const std::vector<std::string> rest = {"--quick", "--against", "ekf", "--trajectories", "1", "--json"};
  std::vector<std::string> arguments = {"evaluate", "run/model.json", "--conditions", "any.toml"};
  arguments.insert(arguments.end(), rest.begin(), rest.end());
  scratch.write("any.toml", "written_for_deviation = 1.4\n" + both);
  const Json json = Json::parse(scratch.ok(arguments).out);
  EXPECT_EQ(json["conditions"].size(), 1u);
  ASSERT_EQ(json["impossible"].size(), 1u);
  EXPECT_THAT(json["impossible"][0].get<std::string>(), StartsWith("far: "));
  // In a set without written_for_deviation, such a condition is an error.
  scratch.write("any.toml", both);
  EXPECT_THAT(scratch.run(arguments).exit_code, 1);
}

TEST_F(CompareCommand, OldNameWorksAndNamesTheNewCommand) {
  const std::vector<std::string> rest = {
      "run/model.json", "--conditions", "mine.toml", "--seeds", "1", "--no-tuning", "--trajectories", "1",
      "--json",         "--against",    "ekf"};
  std::vector<std::string> evaluate = {"evaluate"}, compare = {"compare"};
  evaluate.insert(evaluate.end(), rest.begin(), rest.end());
  compare.insert(compare.end(), rest.begin(), rest.end());
  const ProgramResult old = scratch.run(compare);
  EXPECT_EQ(old.exit_code, 0);
  EXPECT_EQ(old.out, scratch.ok(evaluate).out);
  EXPECT_THAT(old.err, HasSubstr("nlo compare is now nlo evaluate --conditions default"));
}

TEST_F(CompareCommand, StopsOnInterruptAndLeavesNoFiles) {
  const ProgramResult result = scratch.run(
      {"evaluate", "run/model.json", "--conditions", "default", "--seeds", "200", "--threads", "1", "-o", "out"},
      " %: ");
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_THAT(result.err, HasSubstr("interrupted"));
  EXPECT_FALSE(scratch.has("out"));
}

}  // namespace
}  // namespace nlo::trainer
