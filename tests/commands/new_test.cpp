// SPDX-License-Identifier: MIT
// nlo new: its files are valid, and it reports its guesses. Experiments of users may leave out keys, which the recipe
// then derives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>
#include <regex>
#include <sstream>
#include <string_view>

#include "tests/commands/program.h"
#include "trainer/base/number_text.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A rig log: stamps in ms, an angle that wraps, a command, and the true rate.
std::string rig_log(double phase = 0.0) {
  std::string text = "time_ms,arm_sensor [rad],motor_cmd,rate_true (rad/s)\n";
  for (int k = 0; k < 400; ++k) {
    const double t = 0.01 * k, angle = 4.0 * t + phase;
    text += shortest_text(10.0 * k) + "," + shortest_text(std::remainder(angle, 2.0 * std::numbers::pi)) + "," +
            shortest_text(std::sin(t)) + "," + shortest_text(4.0 + 0.1 * std::sin(t)) + "\n";
  }
  return text;
}

/// Uncomments the lines that are a commented key or section.
std::string with_examples(const std::string& text) {
  static const std::regex kExample(R"(^# (\[[a-z_]+\]|[a-z_]+ = .*)$)");
  std::istringstream lines(text);
  std::string result;
  std::smatch match;
  for (std::string line; std::getline(lines, line);)
    result += (std::regex_match(line, match, kExample) ? match[1].str() : line) + "\n";
  return result;
}

TEST(NewPlant, IsAnExperimentThatTrainsUnchanged) {
  const Scratch scratch;
  const ProgramResult result = scratch.ok({"new", "plant", "-o", "swing.toml"});
  EXPECT_THAT(result.out, HasSubstr("nlo train swing.toml"));
  const std::string text = scratch.read("swing.toml");
  EXPECT_THAT(text, AllOf(HasSubstr("name = \"swing\""), HasSubstr("# inputs = "), HasSubstr("# [feedback]")));
  const Experiment e = parse_draft(text, "swing.toml").experiment;
  EXPECT_EQ(e.plant->states.size(), 2U);
  // With given eigenvalues nothing is derived, which would take long; the tests of drafts below derive.
  const ProgramResult train =
      scratch.ok({"train", "swing.toml", "--set", "observer.eigenvalues=[-3, -6, -9]", "--set", "training.steps=300",
                  "--set", "simulation.trajectories=20", "--set", "inverse_map.hidden=[8]", "-o", "run"});
  EXPECT_THAT(train.err, Not(HasSubstr("warning:"))) << "its runs stay in the range of their initial states";
  EXPECT_EQ(scratch.run({"new", "plant", "-o", "-"}).out.substr(0, 20), text.substr(0, 20));
}

TEST(NewPlant, HasCommentedExamplesThatAreValid) {
  const Scratch scratch;
  scratch.ok({"new", "plant"});
  const std::string all =
      with(with_examples(scratch.read("plant.toml")), "damping * rate\"]", "damping * rate + torque / (l * l)\"]");
  const Experiment e = parse_draft(all, "plant.toml").experiment;
  EXPECT_THAT(e.plant->estimated, ElementsAre("rate"));
  EXPECT_THAT(e.plant->inputs, ElementsAre("torque"));
  EXPECT_TRUE(e.excitation);
  EXPECT_TRUE(e.feedback);
  EXPECT_EQ(e.simulation.process_noise.size(), 2U);
}

TEST(NewLog, ReadsBackWithTheColumnsOfTheLogs) {
  const Scratch scratch;
  for (int i = 0; i < 3; ++i) scratch.write("logs/run" + std::to_string(i) + ".csv", rig_log(i));
  const ProgramResult result = scratch.ok({"new", "log", "logs", "-o", "rig.toml"});
  EXPECT_THAT(result.out,
              AllOf(HasSubstr("time: \"time_ms\" in ms"), HasSubstr("a row every 0.0100 s, even"),
                    HasSubstr("a sensor"), HasSubstr("1200 rows; 1 file train, 1 file validate, 1 file test"),
                    HasSubstr("nlo train rig.toml --data logs\n")));
  const Experiment e = parse_draft(scratch.read("rig.toml"), "rig.toml").experiment;
  EXPECT_EQ(e.name, "rig");
  const LogSplits splits = load_log_splits(*e.log, scratch.path() + "/logs");
  EXPECT_NEAR(splits.train.sample_period_s, 0.01, 1e-9);
  ASSERT_EQ(splits.train.outputs.size(), 2U) << "an angle that wraps becomes sine and cosine";
  EXPECT_EQ(splits.train.outputs[0].name, "arm_sensor_sin");
  ASSERT_EQ(splits.train.states.size(), 1U);
  EXPECT_EQ(splits.train.states[0].name, "rate_true");
  EXPECT_EQ(splits.train.states[0].unit, "rad/s");
  ASSERT_EQ(splits.train.inputs.size(), 1U);
  EXPECT_EQ(splits.train.inputs[0].name, "motor_cmd");
  EXPECT_EQ(splits.test.trajectories.size(), 1U);
}

TEST(NewLog, SaysWhichRoleIsMissingIfAllColumnsHaveOne) {
  const Scratch scratch;
  std::string text = "t,voltage,level\n";
  for (int k = 0; k < 50; ++k)
    text +=
        shortest_text(0.1 * k) + "," + shortest_text(std::sin(0.1 * k)) + "," + shortest_text(std::cos(0.1 * k)) + "\n";
  scratch.write("a.csv", text);
  EXPECT_THAT(scratch.ok({"new", "log", "a.csv", "--inputs", "voltage", "--states", "level"}).out,
              AllOf(HasSubstr("No column is an output"), Not(HasSubstr("numbers do not show"))));
  EXPECT_THAT(scratch.ok({"new", "log", "a.csv", "--outputs", "voltage,level", "--force"}).out,
              HasSubstr("No column is a state"));
  EXPECT_THAT(scratch.ok({"new", "log", "a.csv", "--outputs", "voltage", "--states", "level", "--force"}).out,
              Not(HasSubstr("No column")));
}

TEST(NewLog, AsksForRolesThatNumbersDoNotShow) {
  const Scratch scratch;
  std::string text = "t,position,velocity\n";
  for (int k = 0; k < 100; ++k)
    text += shortest_text(0.01 * k) + "," + shortest_text(std::sin(0.1 * k)) + "," + shortest_text(std::cos(0.1 * k)) +
            "\n";
  scratch.write("a.csv", text);
  const ProgramResult open = scratch.ok({"new", "log", "a.csv"});
  EXPECT_THAT(open.out, HasSubstr("nlo new log a.csv --force --outputs A,B --inputs C --states D,E"));
  EXPECT_THAT(scratch.read("log.toml"), HasSubstr("# CHOOSE its role"));
  // A role that is left open is an error, which names key and line.
  EXPECT_THAT(scratch.run({"train", "log.toml", "--data", "."}).err,
              AllOf(HasSubstr("log.toml:"), HasSubstr("[[log.columns]] role is still CHOOSE: choose it (")));

  EXPECT_EQ(scratch.run({"new", "log", "a.csv", "--outputs", "position", "--states", "velocity"}).exit_code, 2);
  scratch.ok({"new", "log", "a.csv", "--outputs", "position", "--states", "position,velocity", "--force"});
  EXPECT_THAT(scratch.read("log.toml"), Not(HasSubstr("# CHOOSE its role")));
  const Experiment e = parse_draft(scratch.read("log.toml"), "log.toml").experiment;
  const LogSplits splits = load_log_splits(*e.log, scratch.path());
  EXPECT_EQ(splits.train.outputs[0].name, "position_measured");
  ASSERT_EQ(splits.train.states.size(), 2U);
}

TEST(NewLog, AddsAProductOfChannelsIfItHelpsOnLeftOutLogs) {
  const Scratch scratch;
  for (int log = 0; log < 6; ++log) {  // four of them are training logs
    std::string text = "t,gyro,speed,x\n";
    for (int k = 0; k < 300; ++k) {
      const double t = 0.05 * k + 11.0 * log, gyro = std::sin(0.9 * t), speed = 2.0 + std::cos(0.53 * t);
      text += shortest_text(0.05 * k) + "," + shortest_text(gyro) + "," + shortest_text(speed) + "," +
              shortest_text(gyro * speed + 0.02 * std::sin(97.0 * t * t)) + "\n";
    }
    scratch.write("run" + std::to_string(log) + ".csv", text);
  }
  const ProgramResult result = scratch.ok({"new", "log", ".", "--outputs", "gyro,speed", "--states", "x"});
  EXPECT_THAT(result.out, HasSubstr("gyro * speed is added as a computed output"));
  const Experiment e = parse_draft(scratch.read("log.toml"), "log.toml").experiment;
  const LogSplits splits = load_log_splits(*e.log, scratch.path());
  ASSERT_EQ(splits.train.outputs.size(), 3U);
  EXPECT_EQ(splits.train.outputs[2].expression, "gyro * speed");
}

TEST(NewLog, WritesMissingForCellsThatMeanNoValue) {
  const Scratch scratch;
  std::string text = "t,gyro,x_true\n";
  for (int k = 0; k < 300; ++k)
    text += shortest_text(0.05 * k) + "," +
            (k % 100 == 7   ? "-9999"
             : k % 100 == 9 ? "ERR"
                            : shortest_text(std::sin(0.3 * k))) +
            "," + shortest_text(std::cos(0.3 * k)) + "\n";
  scratch.write("a.csv", text);
  const ProgramResult result = scratch.ok({"new", "log", "a.csv"});
  EXPECT_THAT(result.out, AllOf(HasSubstr("a.csv:9: \"gyro\" is -9999 here and in 1 % of its rows"),
                                HasSubstr("delete missing = [\"ERR\", -9999]"), Not(HasSubstr("gyro^2"))));
  EXPECT_THAT(scratch.read("log.toml"), HasSubstr("missing = [\"ERR\", -9999]"));
  const Experiment e = parse_draft(scratch.read("log.toml"), "log.toml").experiment;
  const LogSplits splits = load_log_splits(*e.log, scratch.path());
  EXPECT_EQ(splits.train.trajectories[0].missing.count(), 6);
  EXPECT_LT(splits.train.trajectories[0].outputs.cwiseAbs().maxCoeff(), 1.1);
}

TEST(NewLog, SaysWhyItProposesAWrapThatNoLogCrosses) {
  const Scratch scratch;
  std::string text = "t,yaw_sensor_deg,servo_deg,x_true\n";
  for (int k = 0; k < 300; ++k)
    text += shortest_text(0.05 * k) + "," + shortest_text(175.0 * std::sin(0.3 * k)) + "," +
            shortest_text(175.0 * std::cos(0.3 * k)) + "," + shortest_text(std::sin(0.1 * k)) + "\n";
  scratch.write("a.csv", text);
  const ProgramResult result = scratch.ok({"new", "log", "a.csv"});
  const std::string written = scratch.read("log.toml");
  EXPECT_THAT(written, AllOf(HasSubstr("wrap = 360                      # CHECK: no log shows a jump"),
                             HasSubstr("encoding = \"sincos\"")));
  EXPECT_EQ(written.find("wrap = "), written.rfind("wrap = "))
      << "control: no wrap for a command, which may have limits";
  const Experiment e = parse_draft(written, "log.toml").experiment;
  EXPECT_EQ(load_log_splits(*e.log, scratch.path()).train.outputs[0].name, "yaw_sensor_sin");
}

/// `rows` rows of a clock, two sensors and two states, 36 bytes each.
std::string long_log(int rows, double phase) {
  std::string text = "time,y1_sensor,y2_sensor,x1,x2\n";
  char row[80];
  for (int k = 0; k < rows; ++k) {
    const double t = 0.001 * k, a = std::sin(0.7 * t + phase), b = std::cos(0.7 * t + phase);
    text +=
        std::string_view(row, static_cast<std::size_t>(std::snprintf(row, sizeof row, "%.3f,%.5f,%.5f,%.4f,%.4f\n", t,
                                                                     a + 0.01 * std::sin(997.0 * t), a * b, a, b)));
  }
  return text;
}

TEST(NewLog, UsesAtMostFourTimesTheSizeOfLongLogsInMemory) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "a sanitizer keeps freed memory";
#endif
  const Scratch scratch;
  const auto peak_mb = [&](const std::string& folder, int rows) {
    for (int i = 0; i < 3; ++i)  // three logs, so that products are searched as well
      scratch.write(folder + "/run" + std::to_string(i) + ".csv", long_log(rows, i));
    return scratch.ok({"new", "log", folder + "/run*.csv", "-o", folder + ".toml"}).peak_mb;
  };
  const double small_mb = peak_mb("few", 300), large_mb = peak_mb("many", 300000);
  const double files_mb =
      3.0 * static_cast<double>(std::filesystem::file_size(scratch.path() + "/many/run0.csv")) / 1048576.0;
  EXPECT_GT(files_mb, 25.0);
  EXPECT_LT(large_mb - small_mb, 4.0 * files_mb);
}

TEST(NewLog, AcceptsHeadingsThatAreNotIdentifiersOrHoldQuotes) {
  const Scratch scratch;
  std::string text = "t;\"2nd \"\"gyro\"\"\";\\true\\;while\n";
  for (int k = 0; k < 50; ++k) {
    std::string row = shortest_text(0.01 * k) + ";" + shortest_text(std::sin(0.3 * k)) + ";" +
                      shortest_text(std::cos(0.3 * k)) + ";" + shortest_text(std::sin(0.7 * k)) + "\n";
    std::replace(row.begin(), row.end(), '.', ',');
    text += row;
  }
  scratch.write("a.csv", text);
  const ProgramResult result = scratch.ok({"new", "log", "a.csv", "-o", "a.toml"});
  const Experiment e = parse_draft(scratch.read("a.toml"), "a.toml").experiment;
  const LogSplits splits = load_log_splits(*e.log, scratch.path());
  EXPECT_EQ(splits.train.trajectories[0].samples(), 50);
}

TEST(NewFile, NeverReplacesAFileUnlessForced) {
  const Scratch scratch;
  scratch.write("plant.toml", "mine");
  EXPECT_THAT(scratch.refusal(2, {"new", "plant"}),
              HasSubstr("plant.toml: already exists; write another file with -o FILE, or replace it"));
  EXPECT_EQ(scratch.read("plant.toml"), "mine");
  EXPECT_EQ(scratch.run({"new", "plant", "--force"}).exit_code, 0);
  EXPECT_THAT(scratch.read("plant.toml"), HasSubstr("[plant]"));
  EXPECT_EQ(scratch.run({"new", "log"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"new", "rig"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"new", "log", "nowhere.csv"}).exit_code, 2);
  EXPECT_THAT(scratch.run({"new", "plant", "--states", "x", "-o", "p.toml"}).err, HasSubstr("accepts no logs"));
  EXPECT_FALSE(scratch.has("log.toml"));
}

std::string draft() {
  return with(kTinyExperiment, "eigenvalues = [-1.0, -2.0, -3.0]\n", "");
}

TEST(DraftProgram, TrainsToTheSameBytesAsTheDerivedExperiment) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  const auto train = scratch.ok({"train", "draft.toml", "-o", "a"});
  EXPECT_THAT(train.err, HasSubstr("derived  eigenvalues"));
  EXPECT_THAT(scratch.read("a/derived.toml"), AllOf(HasSubstr("hidden = [8]"), HasSubstr("steps = 20")));
  const auto again = scratch.ok({"train", "a/derived.toml", "-o", "b"});
  EXPECT_THAT(again.err, Not(HasSubstr("derived  eigenvalues")));
  EXPECT_TRUE(scratch.read("a/model.json") == scratch.read("b/model.json"));
  EXPECT_FALSE(scratch.has("b/derived.toml"));
}

TEST(DraftProgram, ResumesToTheSameBytes) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  scratch.ok({"train", "draft.toml", "-o", "a", "-q"});
  const std::string model = scratch.read("a/model.json");
  EXPECT_THAT(scratch.run({"train", "draft.toml", "-o", "a", "--resume"}).out, HasSubstr("already done"));
  std::filesystem::remove(scratch.path() + "/a/finished.json");
  scratch.ok({"train", "draft.toml", "-o", "a", "--resume"});
  EXPECT_TRUE(scratch.read("a/model.json") == model);
}

TEST(DraftProgram, IsQuietWhenAsked) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  EXPECT_EQ(scratch.run({"train", "draft.toml", "-q"}).err, "");
}

TEST(DraftProgram, SimulatesADraftWithoutDerivingAnObserver) {
  const Scratch scratch;
  scratch.write("draft.toml", draft());
  EXPECT_EQ(scratch.run({"simulate", "draft.toml", "-o", "run.csv"}).exit_code, 0);
  EXPECT_TRUE(scratch.has("run.csv"));
}

TEST(DraftProgram, DerivesFromLogs) {
  const Scratch scratch;
  scratch.write("draft.toml", kTinyLogExperiment.substr(0, kTinyLogExperiment.find("[observer]")));
  double phase = 0.0;
  for (const char* file : {"a.csv", "b.csv", "c.csv"}) scratch.write(std::string("logs/") + file, tiny_log(phase++));
  const auto train = scratch.run({"train", "draft.toml", "--data", "logs", "--set", "training.steps=20", "-o", "r"});
  EXPECT_NE(train.exit_code, 2) << train.err;  // 1 if so few steps do not improve the model
  EXPECT_THAT(scratch.read("r/derived.toml"), AllOf(HasSubstr("learn_eigenvalues = false"), HasSubstr("clocks_s = [")));
}

}  // namespace
}  // namespace nlo::trainer
