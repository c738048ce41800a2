// SPDX-License-Identifier: MIT
// Runs the commands one after the other, as a user does.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "codegen/model_file/model_file.h"
#include "tests/commands/program.h"
#include "trainer/config/experiment.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

TEST(Program, PrintsItsVersionAndHelpWithExamples) {
  const Scratch scratch;
  EXPECT_THAT(scratch.run({"--version"}).out, StartsWith("nlo "));
  EXPECT_EQ(scratch.run({"-V"}).out, scratch.run({"--version"}).out);
  for (const char* command : {"train", "evaluate", "certify", "export", "report", "simulate"}) {
    const auto help = scratch.ok({command, "--help"});
    EXPECT_THAT(help.out, HasSubstr("Example")) << command;
  }
  const auto keys = scratch.ok({"train", "--help-config"});
  EXPECT_THAT(keys.out, HasSubstr("[observer]"));
}

TEST(Program, TrainsEvaluatesAndExports) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto train = scratch.ok({"train", "tiny.toml", "--set", "training.steps=30", "--seed", "3"});
  EXPECT_THAT(train.out, HasSubstr("runs/tiny/model.json"));
  EXPECT_NE(train.err, "");
  for (const char* file :
       {"runs/tiny/model.json", "runs/tiny/metrics.csv", "runs/tiny/checkpoint.bin", "runs/tiny/report.html"})
    EXPECT_TRUE(scratch.has(file)) << file;

  const auto json = scratch.ok({"evaluate", "runs/tiny/model.json", "--noise", "gaussian:0.5", "--seed", "5",
                                "--box-scale", "2", "--trajectories", "7", "--json"});
  ASSERT_EQ(nlohmann::json::parse(json.out).size(), 1U) << "one noise gives an array with one element";
  const auto result = nlohmann::json::parse(json.out)[0];
  for (const char* key : {"norm", "nrmse", "settled", "per_component", "settling_time_s", "seed", "noise"})
    EXPECT_TRUE(result.contains(key)) << key;
  EXPECT_EQ(result["seed"], 5);
  EXPECT_EQ(result["noise"], "gaussian:0.5");
  EXPECT_EQ(result["trajectories"], 7);

  const auto table = scratch.ok({"evaluate", "runs/tiny/model.json", "--noise", "none", "--noise", "uniform:1",
                                 "--trajectories", "3", "--against", "ekf,constant"});
  for (const char* word : {"uniform:1", "observer", "ekf", "constant", "ridge", "in domain"})
    EXPECT_THAT(table.out, HasSubstr(word));

  const auto report = scratch.ok({"report", "runs/tiny", "--noise", "uniform:1", "--against", "ekf"});
  EXPECT_THAT(scratch.read("runs/tiny/report.html"), HasSubstr("ekf"));

  for (const char* target : {"cpp", "replay"}) {
    scratch.ok({"export", "runs/tiny/model.json", "--target", target, "-o", "tiny.h"});
    EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("tiny"));
  }
  const auto int16 =
      scratch.ok({"export", "runs/tiny/model.json", "--scalar", "int16", "--max-error", "1", "-o", "tiny.h"});
  EXPECT_THAT(int16.out, HasSubstr("error of int16 against the model's equations"));
  EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("QuantisedDense<"));
  EXPECT_EQ(scratch.run({"export", "runs/tiny/model.json", "-o", "-"}).out.empty(), false);
  const auto quiet = scratch.ok({"export", "runs/tiny/model.json", "--quiet", "-o", "tiny.h"});
  EXPECT_EQ(quiet.out + quiet.err, "");
  EXPECT_EQ(scratch.run({"export", "runs/tiny/model.json", "-o", "new/folder/tiny.h"}).exit_code, 0);
  EXPECT_TRUE(scratch.has("new/folder/tiny.h"));
  const auto halves = scratch.ok({"export", "runs/tiny/model.json", "--weights", "bf16", "-o", "tiny.h"});
  EXPECT_THAT(halves.out, HasSubstr("bf16"));
  EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("Dense<Bfloat16"));

  scratch.ok({"export", "runs/tiny/model.json", "--target", "c99", "--name", "fly", "-o", "fly.h"});
  EXPECT_THAT(scratch.read("fly.c"), HasSubstr("#include \"fly.h\""));
  EXPECT_THAT(scratch.refusal(2, {"export", "runs/tiny/model.json", "--target", "c99", "-o", "other.h"}),
              HasSubstr("write -o tiny.h"));
  EXPECT_FALSE(scratch.has("other.h"));
  EXPECT_EQ(scratch.run({"export", "runs/tiny/model.json", "--target", "c99", "-o", "-"}).exit_code, 2);

  scratch.ok({"export", "runs/tiny/model.json", "--target", "fmu-sources", "-o", "tiny.fmu"});
  EXPECT_EQ(scratch.read("tiny.fmu").substr(0, 2), "PK");

  for (const char* target : {"arduino", "zephyr", "selftest", "simulink", "ros2_control", "px4", "simplefoc"}) {
    const std::string folder = std::string(target) + "_tiny";
    std::vector<std::string> command = {"export", "runs/tiny/model.json", "--target", target, "-o", folder};
    if (folder == "simplefoc_tiny") command.insert(command.end(), {"--roles", "angle=none,velocity=x2"});
    EXPECT_EQ(scratch.run(command).exit_code, 0);
    EXPECT_EQ(scratch.run(command).exit_code, 0) << "a folder that it wrote itself must be replaceable";
    scratch.write(folder + "/mine.txt", "mine");
    EXPECT_THAT(scratch.refusal(2, command), HasSubstr("mine.txt: was added or changed"));
    EXPECT_EQ(scratch.read(folder + "/mine.txt"), "mine");
  }
  const auto roles = [&](const char* target, const char* given) {
    return scratch.refusal(2,
                           {"export", "runs/tiny/model.json", "--target", target, "--roles", given, "-o", "a_sensor"});
  };
  EXPECT_THAT(roles("simplefoc", "angle=none"), HasSubstr("which state is the velocity;"));
  EXPECT_THAT(roles("simplefoc", "angle=none"), HasSubstr("write --roles velocity=NAME with one of x1, x2"));
  EXPECT_THAT(roles("simplefoc", "velocity=x2"), HasSubstr("write --roles angle=NAME with one of y, or none"));
  EXPECT_THAT(roles("simplefoc", "angle=none,velocity=x3"), HasSubstr("there is no such state; there are x1, x2"));
  EXPECT_THAT(roles("simplefoc", "speed=x2"), HasSubstr("there are angle, velocity"));
  EXPECT_THAT(roles("px4", "velocity=x2"), HasSubstr("target px4 has no roles"));
  EXPECT_FALSE(scratch.has("a_sensor"));
}

TEST(Program, RecordsTheExperimentOfTheModel) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-o", "a", "-q", "--set", "training.steps=3"});
  const auto model = codegen::read_model(scratch.path() + "/a/model.json");
  std::string config;
  for (const auto& [key, text] : model.provenance)
    if (key == "config") config = text;
  EXPECT_EQ(parse_experiment(config, "provenance").training.steps, 3);
}

TEST(Program, TheSameSeedGivesTheSameModelForAnyNumberOfThreads) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.ok({"train", "tiny.toml", "-o", "a", "-q", "--threads", "1"});
  scratch.ok({"train", "tiny.toml", "-o", "b", "-q", "--threads", "3"});
  scratch.ok({"train", "tiny.toml", "-o", "c", "-q", "--seed", "2"});
  EXPECT_TRUE(scratch.read("a/model.json") == scratch.read("b/model.json"));
  EXPECT_FALSE(scratch.read("a/model.json") == scratch.read("c/model.json"));
}

TEST(Program, ReplacesItsOwnModelAndOthersOnlyWithForce) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.write("other.toml", with(kTinyExperiment, "\"tiny\"", "\"other\""));
  scratch.ok({"train", "tiny.toml", "-o", "a", "-q"});
  EXPECT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q"}).exit_code, 0);
  EXPECT_EQ(scratch.run({"train", "other.toml", "-o", "a", "-q"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"train", "other.toml", "-o", "a", "-q", "--force"}).exit_code, 0);
}

TEST(Program, AnInterruptedRunContinuesToTheSameModel) {
  const Scratch scratch;
  scratch.write("tiny.toml", with(kTinyExperiment, "steps = 20", "steps = 6000"));
  const auto interrupted = scratch.run({"train", "tiny.toml", "-o", "a"}, "step 600 of");
  ASSERT_EQ(interrupted.exit_code, 1) << interrupted.err;
  EXPECT_THAT(interrupted.err, HasSubstr("interrupted after"));
  EXPECT_THAT(interrupted.err, HasSubstr("nlo train tiny.toml -o a --resume"));
  EXPECT_THAT(interrupted.err, HasSubstr("a/model.json has the best model so far"));
  EXPECT_EQ(scratch.run({"evaluate", "a/model.json", "--trajectories", "2"}).exit_code, 0);
  scratch.ok({"train", "tiny.toml", "-o", "a", "-q", "--resume"});
  scratch.ok({"train", "tiny.toml", "-o", "b", "-q"});
  EXPECT_TRUE(scratch.read("a/model.json") == scratch.read("b/model.json"));
}

TEST(Program, AFinishedRunIsResumedWithMoreSteps) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto with_steps = [&](const char* steps) {
    return scratch.run({"train", "tiny.toml", "-o", "a", "-q", "--resume", "--set", steps});
  };
  scratch.ok({"train", "tiny.toml", "-o", "a", "-q"});
  const auto more = with_steps("training.steps=40");
  EXPECT_EQ(more.exit_code, 0) << more.err;
  EXPECT_THAT(scratch.read("a/metrics.csv"), AllOf(HasSubstr("\n20,"), HasSubstr("\n40,")));
  const auto fewer = with_steps("training.steps=30");
  EXPECT_NE(fewer.exit_code, 0);
  EXPECT_THAT(fewer.err, HasSubstr("40 steps are done and training.steps asks for 30"));
  const auto other = with_steps("training.learning_rate=0.5");
  EXPECT_NE(other.exit_code, 0) << "control: any other change makes it another run";
}

TEST(Program, ATrainingWithoutProgressFailsAndKeepsItsModel) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const std::string run = scratch.refusal(1, {"train", "tiny.toml", "-o", "a", "-q", "--set",
                                              "inverse_map.linear_path=true", "--set", "training.learning_rate=30"});
  EXPECT_THAT(run, HasSubstr("training made no progress"));
  EXPECT_THAT(run, HasSubstr("learning_rate = 30 may be too high"));
  EXPECT_TRUE(scratch.has("a/model.json"));
  EXPECT_TRUE(scratch.read("a/report.html").find("training made no progress") != std::string::npos);
}

TEST(Program, ATrainingWhoseClosedFormIsBestSucceedsAndSaysSo) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const ProgramResult run = scratch.ok({"train", "tiny.toml", "-o", "a", "-q", "--set", "inverse_map.linear_path=true",
                                        "--set", "training.learning_rate=1e-30"});
  EXPECT_THAT(run.out, HasSubstr("note     the closed form is best"));
  EXPECT_THAT(scratch
                  .ok({"train", "tiny.toml", "-o", "a", "-q", "--set", "inverse_map.linear_path=true", "--set",
                       "training.learning_rate=1e-30", "--resume"})
                  .out,
              HasSubstr("already done"));
}

TEST(Program, ADivergingRunSaysWhatToTryAndKeepsTheBestModel) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  EXPECT_THAT(scratch.refusal(1, {"train", "tiny.toml", "-o", "a", "-q", "--set", "training.learning_rate=1e30"}),
              HasSubstr("Try a lower learning_rate"));
  EXPECT_NO_THROW(codegen::read_model(scratch.path() + "/a/model.json"));
}

TEST(Program, SimulatedLogsCanBeTrainedOn) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.write("logs/.keep", "");
  const auto simulate = scratch.ok({"simulate", "tiny.toml", "--trajectories", "2", "--noise", "gaussian:0.05",
                                    "--seed", "4", "-o", "logs/run.csv"});
  EXPECT_THAT(scratch.read("logs/run_2.csv"), StartsWith("trajectory,time,y,y_measured,x1,x2\n2,0,"));

  std::string log = with(kTinyLogExperiment, "a.csv", "run_1.csv");
  log = with(with(log, "b.csv", "run_2.csv"), "name = \"y\"", "name = \"y\"\ncolumn = \"y_measured\"");
  log = with(with(log, "name = \"v\"", "name = \"x2\""), "derivative_of = \"y\"\n", "");
  log = with(log, "role = \"time\"", "role = \"time\"\n[[log.columns]]\nname = \"x1\"\nrole = \"state\"");
  scratch.write("log.toml", log);
  const Dataset read = load_logs(*parse_experiment(log, "log.toml").log, scratch.path() + "/logs", {"run_1.csv"});
  EXPECT_EQ(read.trajectories[0].samples(), 241);
  EXPECT_NEAR(read.sample_period_s, 0.05, 1e-12);
  const auto train = scratch.ok({"train", "log.toml", "--data", "logs", "-o", "out", "-q"});
  const auto evaluate = scratch.ok({"evaluate", "out/model.json", "--data", "logs/run_2.csv", "--json"});
  EXPECT_TRUE(nlohmann::json::parse(evaluate.out)[0].contains("per_component"));
}

TEST(Program, ShippedExperimentsAreKnownByName) {
  const Scratch scratch;
  const auto simulate = scratch.ok({"simulate", "van_der_pol", "-o", "x.csv"});
  EXPECT_TRUE(scratch.has("x.csv"));
}

}  // namespace
}  // namespace nlo::trainer
