// SPDX-License-Identifier: MIT
// nlo evaluate --figure and --estimates: the files contain the evaluated data. `-o -` writes the file of a command to
// stdout, and nothing else.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <tuple>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::EndsWith;
using testing::HasSubstr;
using testing::StartsWith;

class RunFiles : public testing::Test {
 protected:
  void SetUp() override {
    scratch.write("log.toml", kTinyLogExperiment);
    scratch.write("logs/a.csv", tiny_log(0.0, 400));
    scratch.write("logs/b.csv", tiny_log(0.5, 400));
    const ProgramResult train = scratch.ok({"train", "log.toml", "--data", "logs", "-o", "out", "-q"});
  }

  ProgramResult evaluate(std::vector<std::string> arguments) const {
    std::vector<std::string> all{"evaluate", "out/model.json", "--data"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    return scratch.run(all);
  }

  Scratch scratch;
};

std::vector<std::map<std::string, double>> rows(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line, field;
  std::getline(lines, line);
  std::vector<std::string> names;
  for (std::istringstream heading(line); std::getline(heading, field, ',');) names.push_back(field);
  std::vector<std::map<std::string, double>> result;
  while (std::getline(lines, line)) {
    result.emplace_back();
    std::istringstream fields(line);
    for (const std::string& name : names) {
      std::getline(fields, field, ',');
      result.back()[name] = std::strtod(field.c_str(), nullptr);
    }
  }
  return result;
}

TEST(LogsOfAPlant, AreScoredOnlyInStatesWithATruth) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-o", "out", "-q"});
  scratch.ok({"simulate", "tiny.toml", "-o", "all.csv"});
  std::istringstream lines(scratch.read("all.csv"));
  std::string without;
  for (std::string line; std::getline(lines, line);) without += line.substr(0, line.rfind(',')) + "\n";
  scratch.write("some.csv", without);  // without x2, the last column

  const auto all = scratch.run({"evaluate", "out/model.json", "--data", "all.csv"});
  const auto some = scratch.ok({"evaluate", "out/model.json", "--data", "some.csv", "--estimates", "e.csv"});
  const auto line_of_x1 = [](const std::string& text) {
    const std::string before = "  x1\n    ";
    const auto at = text.find(before + "observer");
    if (at == std::string::npos) return std::string("none");
    return text.substr(at + before.size(), text.find('\n', at + before.size()) - at - before.size());
  };
  EXPECT_EQ(line_of_x1(some.out), line_of_x1(all.out));
  EXPECT_THAT(line_of_x1(some.out), StartsWith("observer"));
  EXPECT_THAT(some.out, HasSubstr("unscored: x2, because these logs have no truth for them"));
  EXPECT_THAT(some.out, testing::Not(HasSubstr("  x2\n")));
  EXPECT_THAT(all.out, HasSubstr("  x2\n    observer"));
  for (const auto& row : rows(scratch.read("e.csv"))) {
    EXPECT_TRUE(std::isfinite(row.at("x2_estimate")));
    EXPECT_TRUE(std::isnan(row.at("x2_truth")));
    EXPECT_TRUE(std::isfinite(row.at("x1_truth")));
  }
}

TEST_F(RunFiles, EstimatesAreThoseOfTheEvaluation) {
  const auto result = evaluate({"logs/b.csv", "--estimates", "b_out.csv", "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string csv = scratch.read("b_out.csv");
  EXPECT_THAT(csv, StartsWith("time,step_s,y,v_estimate,in_domain,v_truth\n"));
  const auto samples = rows(csv);
  ASSERT_EQ(samples.size(), 400U);
  double squares = 0.0, scored = 0.0, inside = 0.0;
  for (const auto& sample : samples) {
    EXPECT_EQ(sample.at("step_s"), 0.0);  // the log is sampled evenly
    if (&sample != &samples.front()) inside += sample.at("in_domain");
    if (std::isnan(sample.at("v_truth"))) continue;
    squares += std::pow(sample.at("v_estimate") - sample.at("v_truth"), 2);
    scored += 1.0;
  }
  EXPECT_NEAR(samples[123].at("y"), std::sin(1.23 + 0.5), 1e-6);
  EXPECT_GT(scored, 300.0);
  EXPECT_LT(scored, 400.0);  // the ends are masked because of the filter
  const nlohmann::json said = nlohmann::json::parse(result.out)[0];
  EXPECT_NEAR(said["per_component"][0].get<double>(), std::sqrt(squares / scored), 1e-5 * std::sqrt(squares / scored));
  EXPECT_NEAR(said["in_domain"]["share"].get<double>(), inside / 399.0, 1e-9);
}

TEST_F(RunFiles, SeveralLogsAndStartsAreNumbered) {
  const auto result = evaluate({"logs/b.csv", "--from", "0,1", "--estimates", "x.csv"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.err, HasSubstr("x_2.csv: b.csv from 1 s"));
  EXPECT_EQ(rows(scratch.read("x_1.csv")).size(), 400U);
  EXPECT_EQ(rows(scratch.read("x_2.csv")).size(), 300U);
  EXPECT_FALSE(scratch.has("x.csv"));
}

TEST_F(RunFiles, ThePictureNamesTheLog) {
  if (std::system("gnuplot --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "gnuplot is not installed";
  const auto result = evaluate({"logs/b.csv", "--figure", "b.svg"});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::string svg = scratch.read("b.svg");
  EXPECT_THAT(svg, StartsWith("<svg"));
  EXPECT_THAT(svg, HasSubstr("time [s], b.csv: RMSE v "));
  EXPECT_THAT(svg, HasSubstr("error [m/s]"));
  EXPECT_LT(svg.size(), 60'000U);
}

TEST_F(RunFiles, AreRefusedBeforeTheEvaluation) {
  for (const auto& [option, file, said] : {std::tuple{"--figure", "b.png", "write FILE.svg"},
                                           {"--estimates", "b.json", "write FILE.csv"},
                                           {"--estimates", "nowhere/b.csv", "nowhere"}}) {
    const auto result = evaluate({"logs/b.csv", option, file});
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_THAT(result.err, HasSubstr(said));
    EXPECT_EQ(result.out, "");
  }
  const auto twice = evaluate({"logs/b.csv", "--noise", "none", "--noise", "gaussian:0.1", "--figure", "b.svg"});
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_THAT(twice.err, HasSubstr("one --noise"));
  const std::string plant = scratch.refusal(2, {"evaluate", "out/model.json", "--figure", "b.svg"});
}

class Stdout : public testing::Test {
 protected:
  Stdout() {
    scratch_.write("tiny.toml", kTinyExperiment);
    EXPECT_EQ(scratch_.run({"train", "tiny.toml", "-o", "run", "-q", "--set", "training.steps=3"}).exit_code, 0);
  }
  /// Expects the same text in the file and on stdout.
  void expect_same(std::vector<std::string> command, const std::string& file) {
    command.insert(command.end(), {"-o", file});
    scratch_.ok(command);
    command.back() = "-";
    const auto before = scratch_.contents();
    const auto streamed = scratch_.ok(command);
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

TEST_F(Stdout, GetsTheFileOfEachCommandThatWritesOne) {
  expect_same({"simulate", "tiny.toml", "--noise", "gaussian:0.1"}, "run.csv");
  expect_same({"report", "run", "--noise", "none"}, "report.html");
  expect_same({"export", "run/model.json", "-q"}, "tiny.h");
}

TEST_F(Stdout, IsRefusedForCommandsThatWriteSeveralFiles) {
  expect_refused({"simulate", "tiny.toml", "--trajectories", "2", "-o", "-"}, "2 trajectories");
  expect_refused({"train", "tiny.toml", "-q", "-o", "-"}, "a folder of files");
  expect_refused({"reproduce", "table1", "--quick", "-o", "-"}, "a folder of files");
  expect_refused({"export", "run/model.json", "--target", "c99", "-o", "-"}, "several files");
}

TEST(SeveralNoises, ApplyOneToEachOutput) {
  const Scratch scratch;
  const std::string two = with(kTinyExperiment, "model = \"van_der_pol\"",
                               "states = [\"x1\", \"x2\"]\nderivative = [\"x2\", \"-x1\"]\noutputs = [\"x1\", \"x2\"]");
  scratch.write("two.toml", with(two, "\"gaussian:0.1\"", "[\"gaussian:0.1\", \"none\"]"));
  const auto train = scratch.ok({"train", "two.toml", "-o", "run", "-q"});
  EXPECT_THAT(train.out, HasSubstr("noise gaussian:0.1,none"));
  EXPECT_THAT(scratch.read("run/report.html"), HasSubstr("N(0, 0.1), no noise"));
  const auto json = scratch.ok({"evaluate", "run/model.json", "--noise", "gaussian:0.1,uniform:0.02", "--json",
                                "--trajectories", "3", "--against", "ekf"});
  EXPECT_THAT(json.out, HasSubstr("gaussian:0.1,uniform:0.02"));
  for (const std::vector<std::string>& command : {std::vector<std::string>{"evaluate", "run/model.json"},
                                                  {"report", "run"},
                                                  {"simulate", "two.toml", "-o", "-"}}) {
    std::vector<std::string> wrong = command;
    wrong.insert(wrong.end(), {"--noise", "none,none,none"});
    EXPECT_THAT(scratch.refusal(2, wrong), HasSubstr("is for 3 outputs, but there are 2"));
  }
  const auto csv = scratch.run({"simulate", "two.toml", "--noise", "none,uniform:1", "-o", "-"});
  EXPECT_THAT(csv.out, StartsWith("trajectory,time,y1,y2,y1_measured,y2_measured,x1,x2\n"));
  EXPECT_THAT(csv.out, EndsWith("\n"));
}

}  // namespace
}  // namespace nlo::trainer
