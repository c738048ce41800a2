// SPDX-License-Identifier: MIT
// nlo evaluate on plants and on logs, and nlo monitor on a plant, on logs, a second time and in the exported header,
// both run as a user does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <tuple>

#include "tests/commands/program.h"
#include "trainer/base/number_text.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(Evaluate, ManyTestSetsAndTrainingSeedsHaveStandardErrors) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  for (const char* seed : {"1", "2"}) scratch.ok({"train", "tiny.toml", "-q", "--seed", seed, "-o", seed});
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"evaluate", "1/model.json", "--trajectories", "3", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = scratch.ok(arguments);
    return nlohmann::json::parse(result.out);
  };
  const auto both = run({"2/model.json", "--seeds", "3", "--seed", "4", "--noise", "none", "--noise", "gaussian:0.5"});
  ASSERT_EQ(both.size(), 2U) << "an object for each noise";
  for (const auto& noise : both) {
    EXPECT_GT(noise["standard_error"]["over_test_sets"]["norm"].get<double>(), 0.0);
    EXPECT_GT(noise["standard_error"]["over_training_seeds"]["norm"].get<double>(), 0.0);
    EXPECT_TRUE(noise["against"].contains("constant") && noise["against"].contains("ridge"));
  }
  // The mean over seeds 4 to 6 equals that of three separate tests.
  double sum = 0.0;
  for (const char* seed : {"4", "5", "6"}) sum += run({"--seed", seed})[0]["norm"].get<double>();
  EXPECT_NEAR(run({"--seeds", "3", "--seed", "4"})[0]["norm"].get<double>(), sum / 3.0, 1e-12);
}

TEST(Evaluate, OnlyTheFilterWithTrueParametersFollowsAChangedPlant) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-q", "-o", "a"});
  const auto run = scratch.ok({"evaluate", "a/model.json", "--trajectories", "3", "--json", "--set",
                               "plant.parameters.mu=1.5", "--against", "ekf,ekf_true"});
  const auto result = nlohmann::json::parse(run.out)[0];
  EXPECT_EQ(result["changed"], "plant.parameters.mu=1.5");
  EXPECT_EQ(result["against"]["ekf"]["label"], "ekf, nominal parameters");
  EXPECT_GT(result["against"]["ekf"]["norm"].get<double>(), 2.0 * result["against"]["ekf_true"]["norm"].get<double>());
}

TEST(Evaluate, EvaluatesAModelOfAPlantOnLogs) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-q", "-o", "a"});
  scratch.ok({"simulate", "tiny.toml", "--seed", "4", "-o", "run.csv"});
  const auto by_heading = scratch.ok({"evaluate", "a/model.json", "--data", "run.csv", "--json"});
  const auto result = nlohmann::json::parse(by_heading.out)[0];
  EXPECT_EQ(result["per_state"].size(), 2U);
  EXPECT_EQ(result["samples"], 241);

  std::string renamed = scratch.read("run.csv");
  renamed = with(renamed, "time,y,y_measured,x1,x2", "ms,pos,y_measured,p,v");
  scratch.write("renamed.csv", renamed);
  scratch.write("columns.toml", R"([log]
sample_period_s = 0.05
[[log.columns]]
name = "y"
column = "pos"
role = "output"
[[log.columns]]
name = "x1"
column = "p"
role = "state"
[[log.columns]]
name = "x2"
column = "v"
role = "state"
)");
  const auto by_table =
      scratch.ok({"evaluate", "a/model.json", "--data", "renamed.csv", "--columns", "columns.toml", "--json"});
  EXPECT_NEAR(nlohmann::json::parse(by_table.out)[0]["norm"].get<double>(), result["norm"].get<double>(), 1e-9);
}

TEST(Evaluate, ReadsTheFileThatNewLogWritesAsATableOfColumns) {
  const Scratch scratch;
  scratch.write("logs/a.csv", tiny_log(0.0));
  scratch.write("logs/b.csv", tiny_log(1.0));
  scratch.write("log.toml", kTinyLogExperiment);
  scratch.ok({"train", "log.toml", "--data", "logs", "-q", "-o", "a"});
  std::string text = "ms;Y [cm];V [m/s]\n";
  for (int k = 0; k < 300; ++k) {
    std::string row = shortest_text(10.0 * k) + ";" + shortest_text(100.0 * std::sin(0.01 * k + 2.0)) + ";" +
                      shortest_text(std::cos(0.01 * k + 2.0)) + "\n";
    std::ranges::replace(row, '.', ',');
    text += row;
  }
  scratch.write("new.csv", text);
  scratch.ok({"new", "log", "new.csv", "--outputs", "y", "--states", "v", "-o", "new.toml"});
  const auto read = scratch.ok({"evaluate", "a/model.json", "--data", "new.csv", "--columns", "new.toml", "--json"});
  EXPECT_EQ(nlohmann::json::parse(read.out)[0]["samples"], 300);

  scratch.write("open.csv", with(text, "Y [cm];V [m/s]", "P [cm];Q [m/s]"));
  // Control: open roles are refused, and the error names their line.
  scratch.ok({"new", "log", "open.csv", "-o", "open.toml"});
  EXPECT_THAT(scratch.run({"evaluate", "a/model.json", "--data", "open.csv", "--columns", "open.toml"}).err,
              AllOf(HasSubstr("open.toml:"), HasSubstr("role is still CHOOSE")));
}

TEST(Evaluate, ConvertsColumnsToTheUnitsOfTheModelAndRefusesOtherKinds) {
  const Scratch scratch;
  std::string metres, centimetres = "time,y\n";
  metres = tiny_log(0.0);
  for (int k = 0; k < 300; ++k)
    centimetres += shortest_text(0.01 * k) + "," + shortest_text(100.0 * std::sin(0.01 * k)) + "\n";
  scratch.write("logs/a.csv", metres);
  scratch.write("logs/b.csv", tiny_log(1.0));
  scratch.write("cm.csv", centimetres);
  scratch.write("log.toml", kTinyLogExperiment);
  scratch.ok({"train", "log.toml", "--data", "logs", "-o", "a", "-q"});
  const auto columns = [&](const std::string& position, const std::string& velocity) {
    scratch.write("columns.toml",
                  "[[log.columns]]\nname = \"time\"\nrole = \"time\"\nunit = \"s\"\n[[log.columns]]\nname = "
                  "\"y\"\nrole = \"output\"\nunit = \"" +
                      position + "\"\n[[log.columns]]\nname = \"v\"\nrole = \"state\"\nunit = \"" + velocity +
                      "\"\nderivative_of = \"y\"\n");
    return scratch.run({"evaluate", "a/model.json", "--data", "cm.csv", "--columns", "columns.toml", "--json"});
  };
  const auto own = scratch.ok({"evaluate", "a/model.json", "--data", "logs/a.csv", "--json"});
  const double expected = nlohmann::json::parse(own.out)[0]["norm"].get<double>();
  const auto converted = columns("cm", "cm/s");
  ASSERT_EQ(converted.exit_code, 0) << converted.err;
  const auto result = nlohmann::json::parse(converted.out)[0];
  EXPECT_NEAR(result["norm"].get<double>(), expected, 1e-6 * expected);
  EXPECT_THAT(converted.out, HasSubstr("converted to the unit that the model was trained with, m"));
  EXPECT_NE(nlohmann::json::parse(columns("m", "m/s").out)[0]["norm"].get<double>(), expected);  // control

  const auto other_kind = columns("V", "m/s");
  EXPECT_EQ(other_kind.exit_code, 2);
  EXPECT_THAT(other_kind.err,
              HasSubstr("columns.toml: [[log.columns]] \"y\": its unit is \"V\" (voltage), but the model uses "
                        "\"m\" (length), which measures another kind of quantity"));
  const auto unknown = columns("cubit", "m/s");
  ASSERT_EQ(unknown.exit_code, 0) << unknown.err;
  EXPECT_THAT(unknown.out, HasSubstr("the table of units does not have both"));
}

TEST(Evaluate, UsesValidationLogsWithoutTestLogsAndSaysSo) {
  const Scratch scratch;
  scratch.write("logs/a.csv", tiny_log(0.0));
  scratch.write("logs/b.csv", tiny_log(1.0));
  scratch.write("logs/c.csv", tiny_log(2.0));
  const std::string with_test = with(kTinyLogExperiment, "[\"b.csv\"]", "[\"b.csv\"]\ntest_files = [\"c.csv\"]");
  const std::string alone = with(kTinyLogExperiment, "validation_files = [\"b.csv\"]\n", "");
  for (const auto& [config, log, said] : {std::tuple{with_test, "c.csv", ""},
                                          {kTinyLogExperiment, "b.csv", "These are the validation logs"},
                                          {alone, "a.csv", "These are the training logs"}}) {
    scratch.write("log.toml", config);
    const auto train = scratch.ok({"train", "log.toml", "--data", "logs", "-o", "out", "-q"});
    EXPECT_THAT(train.out, HasSubstr(said));
    const std::string page = scratch.read("out/report.html");
    EXPECT_THAT(page, HasSubstr(std::string("<figcaption>") + log));
    EXPECT_THAT(page, HasSubstr(said));
    EXPECT_EQ(page.find("These are the") != std::string::npos, *said != '\0');
    scratch.ok({"report", "out", "--data", "logs"});
    EXPECT_EQ(scratch.read("out/report.html"), page);
  }
}

TEST(Evaluate, NamesLogsThatTrainedTheModelAndLogsWithAnotherClock) {
  const Scratch scratch;
  scratch.write("log.toml", kTinyLogExperiment);
  scratch.write("logs/a.csv", tiny_log(0.0, 400));
  scratch.write("logs/b.csv", tiny_log(0.5034, 400));
  scratch.ok({"train", "log.toml", "--data", "logs", "-o", "out", "-q"});
  const auto evaluate = [&](const std::string& name, const std::string& log) {
    scratch.write(name, log);
    const auto result = scratch.ok({"evaluate", "out/model.json", "--data", name});
    return result.out;
  };
  EXPECT_THAT(evaluate("renamed.csv", tiny_log(0.0, 300)), HasSubstr("renamed.csv: it contains about"));
  EXPECT_THAT(evaluate("other.csv", tiny_log(2.0071, 400)), Not(HasSubstr("it contains about")));
  std::string half = "time,y\n";
  for (int k = 0; k < 200; ++k)
    half += shortest_text(0.02 * k) + "," + shortest_text(std::sin(0.02 * k + 2.0071)) + "\n";
  EXPECT_THAT(evaluate("half.csv", half), HasSubstr("have the period 0.02 s, but the nominal sample period is 0.01 s"));
}

TEST(Evaluate, AppliesTheGivenInputInSimulationAndEvaluation) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto simulate = scratch.ok({"simulate", "tiny.toml", "--input", "1 + t", "-o", "run.csv"});
  const std::string csv = scratch.read("run.csv");
  EXPECT_THAT(csv, StartsWith("trajectory,time,y,y_measured,x1,x2,u\n1,0,"));
  EXPECT_THAT(csv, HasSubstr(",1\n1,0.05,"));
  EXPECT_THAT(csv, HasSubstr(",1.05\n1,0.1,"));

  scratch.ok({"train", "tiny.toml", "-o", "a", "-q"});
  const auto norms = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"evaluate",  "a/model.json", "--trajectories", "3",
                                          "--against", "ekf",          "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = scratch.ok(arguments);
    return nlohmann::json::parse(run.out)[0];
  };
  const auto alone = norms({}), excited = norms({"--input", "2*cos(12*t)"});
  EXPECT_TRUE(alone["excitation"].empty());
  EXPECT_EQ(excited["excitation"]["u"], "2*cos(12*t)");
  EXPECT_NE(alone["norm"], excited["norm"]);
  EXPECT_LT(excited["against"]["ekf"]["norm"].get<double>(), 0.1) << "the EKF knows u";
}

TEST(MonitorCommand, AddsAMonitorToTheModelAndItsHeader) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-o", "run", "-q"});
  const std::string before = scratch.read("run/model.json");
  const auto watched = scratch.ok(
      {"monitor", "run/model.json", "--quick", "--hours", "0.05", "--runs", "3", "-o", "new.json", "--json"});
  EXPECT_EQ(scratch.read("run/model.json"), before);
  const auto json = nlohmann::json::parse(watched.out);
  EXPECT_EQ(json["runs"], 3);
  EXPECT_EQ(json["conditions"]["as_trained"]["ratio"], 1.0);
  EXPECT_TRUE(json["conditions"].contains("parameters_high"));
  scratch.ok({"export", "new.json", "-o", "tiny.h"});
  EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("kMonitor"));
  scratch.ok({"export", "new.json", "--target", "c99", "-q", "-o", "firmware/tiny.h"});
  EXPECT_THAT(scratch.read("firmware/tiny.c"), HasSubstr("kWatchMeanLimit"));
  const auto block = scratch.ok({"export", "new.json", "--target", "simulink", "-q", "-o", "block"});
  EXPECT_EQ(block.err + block.out, "");
  EXPECT_THAT(scratch.read("block/tiny_sfun.c"), HasSubstr("tiny_watch("));
  EXPECT_EQ(scratch.run({"export", "new.json", "-q", "-o", "tiny.h"}).err, "");
  // The monitor is the same if it is made again from a model that already has one.
  scratch.ok({"monitor", "new.json", "--hours", "0.05", "--runs", "0", "--threads", "3"});
  const auto again = scratch.ok({"monitor", "run/model.json", "--hours", "0.05", "--runs", "0", "--threads", "1"});
  EXPECT_THAT(again.out, Not(HasSubstr("condition")));
  EXPECT_EQ(scratch.read("new.json"), scratch.read("run/model.json"));
}

TEST(MonitorCommand, MakesTheMonitorOfALogModelFromItsLogs) {
  const Scratch scratch;
  scratch.write("log.toml", kTinyLogExperiment);
  scratch.write("a.csv", tiny_log(0.0, 3000));
  scratch.write("b.csv", tiny_log(1.0, 3000));
  scratch.ok({"train", "log.toml", "--data", ".", "-o", "run", "-q"});
  const auto watched = scratch.ok({"monitor", "run/model.json", "--data", ".", "--time-constant", "0.2"});
  EXPECT_THAT(watched.out, HasSubstr("limits for 1.00 false alarms per hour"));
  EXPECT_THAT(scratch.read("run/model.json"), HasSubstr("\"monitor\""));
  EXPECT_THAT(scratch.refusal(1, {"monitor", "run/model.json", "--data", ".", "--time-constant", "100",
                                  "--false-alarms-per-hour", "20"}),
              HasSubstr("ask for at most 18"));
  EXPECT_THAT(scratch.refusal(1, {"monitor", "run/model.json", "--data", ".", "--time-constant", "100"}),
              HasSubstr("or a shorter --time-constant"));
}

}  // namespace
}  // namespace nlo::trainer
