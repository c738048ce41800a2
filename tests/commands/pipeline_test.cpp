// SPDX-License-Identifier: MIT
// The commands one after the other, as a user would give them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <tuple>

#include "codegen/model_file/model_file.h"
#include "tests/commands/program.h"
#include "trainer/base/number_text.h"
#include "trainer/config/experiment.h"
#include "trainer/data/log_dataset.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

TEST(Program, SaysItsVersionAndHelpsWithExamples) {
  const Scratch scratch;
  EXPECT_THAT(scratch.run({"--version"}).out, StartsWith("nlo "));
  EXPECT_EQ(scratch.run({"-V"}).out, scratch.run({"--version"}).out);
  for (const char* command : {"train", "evaluate", "bound", "export", "report", "simulate", "completion", "man"}) {
    const auto help = scratch.run({command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_THAT(help.out, HasSubstr("Example")) << command;
  }
  const auto keys = scratch.run({"train", "--help-config"});
  EXPECT_EQ(keys.exit_code, 0);
  EXPECT_THAT(keys.out, HasSubstr("[observer]"));
}

TEST(Program, TrainsEvaluatesAndExports) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto train = scratch.run({"train", "tiny.toml", "--set", "training.steps=30", "--seed", "3"});
  ASSERT_EQ(train.exit_code, 0) << train.err;
  EXPECT_THAT(train.out, HasSubstr("runs/tiny/model.json"));
  EXPECT_NE(train.err, "");
  for (const char* file :
       {"runs/tiny/model.json", "runs/tiny/metrics.csv", "runs/tiny/checkpoint.bin", "runs/tiny/report.html"})
    EXPECT_TRUE(scratch.has(file)) << file;

  const auto json = scratch.run({"evaluate", "runs/tiny/model.json", "--noise", "gaussian:0.5", "--seed", "5",
                                 "--box-scale", "2", "--trajectories", "7", "--json"});
  ASSERT_EQ(json.exit_code, 0) << json.err;
  ASSERT_EQ(nlohmann::json::parse(json.out).size(), 1U) << "one noise: an array of one";
  const auto result = nlohmann::json::parse(json.out)[0];
  for (const char* key : {"norm", "nrmse", "settled", "per_component", "settling_time_s", "seed", "noise"})
    EXPECT_TRUE(result.contains(key)) << key;
  EXPECT_EQ(result["seed"], 5);
  EXPECT_EQ(result["noise"], "gaussian:0.5");
  EXPECT_EQ(result["trajectories"], 7);

  const auto table = scratch.run({"evaluate", "runs/tiny/model.json", "--noise", "none", "--noise", "uniform:1",
                                  "--trajectories", "3", "--against", "ekf,constant"});
  ASSERT_EQ(table.exit_code, 0) << table.err;
  for (const char* word : {"uniform:1", "observer", "ekf", "constant", "ridge", "in domain"})
    EXPECT_THAT(table.out, HasSubstr(word));

  const auto report = scratch.run({"report", "runs/tiny", "--noise", "uniform:1", "--against", "ekf"});
  EXPECT_EQ(report.exit_code, 0) << report.err;
  EXPECT_THAT(scratch.read("runs/tiny/report.html"), HasSubstr("ekf"));

  for (const char* target : {"cpp", "replay"}) {
    const auto exported = scratch.run({"export", "runs/tiny/model.json", "--target", target, "-o", "tiny.h"});
    EXPECT_EQ(exported.exit_code, 0) << exported.err;
    EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("tiny"));
  }
  const auto int16 =
      scratch.run({"export", "runs/tiny/model.json", "--scalar", "int16", "--max-error", "1", "-o", "tiny.h"});
  EXPECT_EQ(int16.exit_code, 0) << int16.err;
  EXPECT_THAT(int16.out, HasSubstr("error of int16 against the model's equations"));
  EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("QuantisedDense<"));
  EXPECT_EQ(scratch.run({"export", "runs/tiny/model.json", "-o", "-"}).out.empty(), false);
  const auto quiet = scratch.run({"export", "runs/tiny/model.json", "--quiet", "-o", "tiny.h"});
  EXPECT_EQ(quiet.exit_code, 0);
  EXPECT_EQ(quiet.out + quiet.err, "");
  EXPECT_EQ(scratch.run({"export", "runs/tiny/model.json", "-o", "new/folder/tiny.h"}).exit_code, 0);
  EXPECT_TRUE(scratch.has("new/folder/tiny.h"));
  const auto halves = scratch.run({"export", "runs/tiny/model.json", "--weights", "bf16", "-o", "tiny.h"});
  EXPECT_EQ(halves.exit_code, 0) << halves.err;
  EXPECT_THAT(halves.out, HasSubstr("bf16"));
  EXPECT_THAT(scratch.read("tiny.h"), HasSubstr("Dense<Bfloat16"));

  const auto pair = scratch.run({"export", "runs/tiny/model.json", "--target", "c99", "--name", "fly", "-o", "fly.h"});
  EXPECT_EQ(pair.exit_code, 0) << pair.err;
  EXPECT_THAT(scratch.read("fly.c"), HasSubstr("#include \"fly.h\""));
  const auto misnamed = scratch.run({"export", "runs/tiny/model.json", "--target", "c99", "-o", "other.h"});
  EXPECT_EQ(misnamed.exit_code, 2);
  EXPECT_THAT(misnamed.err, HasSubstr("write -o tiny.h"));
  EXPECT_FALSE(scratch.has("other.h"));
  EXPECT_EQ(scratch.run({"export", "runs/tiny/model.json", "--target", "c99", "-o", "-"}).exit_code, 2);

  for (const char* target : {"arduino", "zephyr"}) {
    const std::string folder = std::string(target) + "_tiny";
    const std::vector<std::string> command = {"export", "runs/tiny/model.json", "--target", target, "-o", folder};
    EXPECT_EQ(scratch.run(command).exit_code, 0);
    EXPECT_EQ(scratch.run(command).exit_code, 0) << "its own folder is not replaced";
    scratch.write(folder + "/mine.txt", "mine");
    const auto refused = scratch.run(command);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, HasSubstr("mine.txt: was added or changed"));
    EXPECT_EQ(scratch.read(folder + "/mine.txt"), "mine");
  }
}

TEST(Program, RecordsWhatTheModelWasTrainedBy) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q", "--set", "training.steps=3"}).exit_code, 0);
  const auto model = codegen::read_model(scratch.path() + "/a/model.json");
  std::string config;
  for (const auto& [key, text] : model.provenance)
    if (key == "config") config = text;
  EXPECT_EQ(parse_experiment(config, "provenance").training.steps, 3);
}

TEST(Program, TheSameSeedGivesTheSameModelForAnyNumberOfThreads) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q", "--threads", "1"}).exit_code, 0);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "b", "-q", "--threads", "3"}).exit_code, 0);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "c", "-q", "--seed", "2"}).exit_code, 0);
  EXPECT_TRUE(scratch.read("a/model.json") == scratch.read("b/model.json"));
  EXPECT_FALSE(scratch.read("a/model.json") == scratch.read("c/model.json"));
}

TEST(Program, ReplacesItsOwnModelAndWithForceAnothers) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.write("other.toml", with(kTinyExperiment, "\"tiny\"", "\"other\""));
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q"}).exit_code, 0);
  EXPECT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q"}).exit_code, 0);
  EXPECT_EQ(scratch.run({"train", "other.toml", "-o", "a", "-q"}).exit_code, 2);
  EXPECT_EQ(scratch.run({"train", "other.toml", "-o", "a", "-q", "--force"}).exit_code, 0);
}

TEST(Program, AnInterruptedRunGoesOnToTheSameModel) {
  const Scratch scratch;
  scratch.write("tiny.toml", with(kTinyExperiment, "steps = 20", "steps = 6000"));
  const auto interrupted = scratch.run({"train", "tiny.toml", "-o", "a"}, "step 600 of");
  ASSERT_EQ(interrupted.exit_code, 1) << interrupted.err;
  EXPECT_THAT(interrupted.err, HasSubstr("interrupted after"));
  EXPECT_THAT(interrupted.err, HasSubstr("nlo train tiny.toml -o a --resume"));
  EXPECT_THAT(interrupted.err, HasSubstr("a/model.json has the best so far"));
  EXPECT_EQ(scratch.run({"evaluate", "a/model.json", "--trajectories", "2"}).exit_code, 0);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q", "--resume"}).exit_code, 0);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "b", "-q"}).exit_code, 0);
  EXPECT_TRUE(scratch.read("a/model.json") == scratch.read("b/model.json"));
}

TEST(Program, AFinishedRunIsResumedWithMoreSteps) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto with_steps = [&](const char* steps) {
    return scratch.run({"train", "tiny.toml", "-o", "a", "-q", "--resume", "--set", steps});
  };
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q"}).exit_code, 0);
  const auto more = with_steps("training.steps=40");
  EXPECT_EQ(more.exit_code, 0) << more.err;
  EXPECT_THAT(scratch.read("a/metrics.csv"), AllOf(HasSubstr("\n20,"), HasSubstr("\n40,")));
  const auto fewer = with_steps("training.steps=30");
  EXPECT_NE(fewer.exit_code, 0);
  EXPECT_THAT(fewer.err, HasSubstr("40 steps are done and training.steps asks for 30"));
  const auto other = with_steps("training.learning_rate=0.5");
  EXPECT_NE(other.exit_code, 0) << "control: all else makes it another run";
}

TEST(Program, ATrainingThatGotNowhereFailsAndKeepsItsModel) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto run = scratch.run({"train", "tiny.toml", "-o", "a", "-q", "--set", "inverse_map.linear_path=true", "--set",
                                "training.learning_rate=30"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("training got nowhere"));
  EXPECT_THAT(run.err, HasSubstr("learning_rate = 30 may be too high"));
  EXPECT_TRUE(scratch.has("a/model.json"));
  EXPECT_TRUE(scratch.read("a/report.html").find("training got nowhere") != std::string::npos);
}

TEST(Program, ADivergingRunSaysWhatToTryAndKeepsTheLastGoodModel) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto result = scratch.run({"train", "tiny.toml", "-o", "a", "-q", "--set", "training.learning_rate=1e30"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_THAT(result.err, HasSubstr("Try a lower learning_rate"));
  EXPECT_NO_THROW(codegen::read_model(scratch.path() + "/a/model.json"));
}

TEST(Program, SimulatedLogsCanBeTrainedOn) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  scratch.write("logs/.keep", "");
  const auto simulate = scratch.run({"simulate", "tiny.toml", "--trajectories", "2", "--noise", "gaussian:0.05",
                                     "--seed", "4", "-o", "logs/run.csv"});
  ASSERT_EQ(simulate.exit_code, 0) << simulate.err;
  EXPECT_THAT(scratch.read("logs/run_2.csv"), StartsWith("trajectory,time,y,y_measured,x1,x2\n2,0,"));

  std::string log = with(kTinyLogExperiment, "a.csv", "run_1.csv");
  log = with(with(log, "b.csv", "run_2.csv"), "name = \"y\"", "name = \"y\"\ncolumn = \"y_measured\"");
  log = with(with(log, "name = \"v\"", "name = \"x2\""), "derivative_of = \"y\"\n", "");
  log = with(log, "role = \"time\"", "role = \"time\"\n[[log.columns]]\nname = \"x1\"\nrole = \"state\"");
  scratch.write("log.toml", log);
  const Dataset read = load_logs(*parse_experiment(log, "log.toml").log, scratch.path() + "/logs", {"run_1.csv"});
  EXPECT_EQ(read.trajectories[0].samples(), 241);
  EXPECT_NEAR(read.sample_period_s, 0.05, 1e-12);
  const auto train = scratch.run({"train", "log.toml", "--data", "logs", "-o", "out", "-q"});
  ASSERT_EQ(train.exit_code, 0) << train.err;
  const auto evaluate = scratch.run({"evaluate", "out/model.json", "--data", "logs/run_2.csv", "--json"});
  ASSERT_EQ(evaluate.exit_code, 0) << evaluate.err;
  EXPECT_TRUE(nlohmann::json::parse(evaluate.out)[0].contains("per_component"));
}

TEST(Program, ManyTestSetsAndTrainingSeedsHaveStandardErrors) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  for (const char* seed : {"1", "2"})
    ASSERT_EQ(scratch.run({"train", "tiny.toml", "-q", "--seed", seed, "-o", seed}).exit_code, 0);
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"evaluate", "1/model.json", "--trajectories", "3", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto result = scratch.run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(result.out);
  };
  const auto both = run({"2/model.json", "--seeds", "3", "--seed", "4", "--noise", "none", "--noise", "gaussian:0.5"});
  ASSERT_EQ(both.size(), 2U) << "an object for each noise";
  for (const auto& noise : both) {
    EXPECT_GT(noise["standard_error"]["over_test_sets"]["norm"].get<double>(), 0.0);
    EXPECT_GT(noise["standard_error"]["over_training_seeds"]["norm"].get<double>(), 0.0);
    EXPECT_TRUE(noise["against"].contains("constant") && noise["against"].contains("ridge"));
  }
  // The mean over seeds 4 to 6 is that of three single tests.
  double sum = 0.0;
  for (const char* seed : {"4", "5", "6"}) sum += run({"--seed", seed})[0]["norm"].get<double>();
  EXPECT_NEAR(run({"--seeds", "3", "--seed", "4"})[0]["norm"].get<double>(), sum / 3.0, 1e-12);
}

TEST(Program, AChangedPlantIsKnownToTheTrueFilterAlone) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-q", "-o", "a"}).exit_code, 0);
  const auto run = scratch.run({"evaluate", "a/model.json", "--trajectories", "3", "--json", "--set",
                                "plant.parameters.mu=1.5", "--against", "ekf,ekf_true"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto result = nlohmann::json::parse(run.out)[0];
  EXPECT_EQ(result["changed"], "plant.parameters.mu=1.5");
  EXPECT_EQ(result["against"]["ekf"]["label"], "ekf, nominal parameters");
  EXPECT_GT(result["against"]["ekf"]["norm"].get<double>(), 2.0 * result["against"]["ekf_true"]["norm"].get<double>());
}

TEST(Program, APlantsModelCanBeEvaluatedOnLogs) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-q", "-o", "a"}).exit_code, 0);
  ASSERT_EQ(scratch.run({"simulate", "tiny.toml", "--seed", "4", "-o", "run.csv"}).exit_code, 0);
  const auto by_heading = scratch.run({"evaluate", "a/model.json", "--data", "run.csv", "--json"});
  ASSERT_EQ(by_heading.exit_code, 0) << by_heading.err;
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
      scratch.run({"evaluate", "a/model.json", "--data", "renamed.csv", "--columns", "columns.toml", "--json"});
  ASSERT_EQ(by_table.exit_code, 0) << by_table.err;
  EXPECT_NEAR(nlohmann::json::parse(by_table.out)[0]["norm"].get<double>(), result["norm"].get<double>(), 1e-9);
}

TEST(Program, ColumnsInAnotherUnitThanTheModelsConvertAndOfAnotherKindAreRefused) {
  const Scratch scratch;
  std::string metres, centimetres = "time,y\n";
  metres = tiny_log(0.0);
  for (int k = 0; k < 300; ++k)
    centimetres += shortest_text(0.01 * k) + "," + shortest_text(100.0 * std::sin(0.01 * k)) + "\n";
  scratch.write("logs/a.csv", metres);
  scratch.write("logs/b.csv", tiny_log(1.0));
  scratch.write("cm.csv", centimetres);
  scratch.write("log.toml", kTinyLogExperiment);
  ASSERT_EQ(scratch.run({"train", "log.toml", "--data", "logs", "-o", "a", "-q"}).exit_code, 0);
  const auto columns = [&](const std::string& position, const std::string& velocity) {
    scratch.write("columns.toml",
                  "[[log.columns]]\nname = \"time\"\nrole = \"time\"\nunit = \"s\"\n[[log.columns]]\nname = "
                  "\"y\"\nrole = \"output\"\nunit = \"" +
                      position + "\"\n[[log.columns]]\nname = \"v\"\nrole = \"state\"\nunit = \"" + velocity +
                      "\"\nderivative_of = \"y\"\n");
    return scratch.run({"evaluate", "a/model.json", "--data", "cm.csv", "--columns", "columns.toml", "--json"});
  };
  const auto own = scratch.run({"evaluate", "a/model.json", "--data", "logs/a.csv", "--json"});
  ASSERT_EQ(own.exit_code, 0) << own.err;
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
              HasSubstr("columns.toml: [[log.columns]] \"y\": its unit is \"V\" (voltage), and the model's is "
                        "\"m\" (length): they are of different kinds"));
  const auto unknown = columns("cubit", "m/s");
  ASSERT_EQ(unknown.exit_code, 0) << unknown.err;
  EXPECT_THAT(unknown.out, HasSubstr("the table of units has not both"));
}

TEST(Program, WithoutTestLogsTheModelIsJudgedByTheValidationLogsAndSaysSo) {
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
    const auto train = scratch.run({"train", "log.toml", "--data", "logs", "-o", "out", "-q"});
    ASSERT_EQ(train.exit_code, 0) << train.err;
    EXPECT_THAT(train.out, HasSubstr(said));
    const std::string page = scratch.read("out/report.html");
    EXPECT_THAT(page, HasSubstr(std::string("<figcaption>") + log));
    EXPECT_THAT(page, HasSubstr(said));
    EXPECT_EQ(page.find("These are the") != std::string::npos, *said != '\0');
    ASSERT_EQ(scratch.run({"report", "out", "--data", "logs"}).exit_code, 0);
    EXPECT_EQ(scratch.read("out/report.html"), page);
  }
}

TEST(Program, EvaluateSaysWhichLogsTrainedTheModelAndWhichHaveAnotherClock) {
  const Scratch scratch;
  scratch.write("log.toml", kTinyLogExperiment);
  scratch.write("logs/a.csv", tiny_log(0.0, 400));
  scratch.write("logs/b.csv", tiny_log(0.5034, 400));
  ASSERT_EQ(scratch.run({"train", "log.toml", "--data", "logs", "-o", "out", "-q"}).exit_code, 0);
  const auto evaluate = [&](const std::string& name, const std::string& log) {
    scratch.write(name, log);
    const auto result = scratch.run({"evaluate", "out/model.json", "--data", name});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return result.out;
  };
  EXPECT_THAT(evaluate("renamed.csv", tiny_log(0.0, 300)), HasSubstr("renamed.csv: trained this model"));
  EXPECT_THAT(evaluate("other.csv", tiny_log(2.0071, 400)), Not(HasSubstr("trained this model")));
  std::string half = "time,y\n";
  for (int k = 0; k < 200; ++k)
    half += shortest_text(0.02 * k) + "," + shortest_text(std::sin(0.02 * k + 2.0071)) + "\n";
  EXPECT_THAT(evaluate("half.csv", half), HasSubstr("regular at 0.02 s, and the nominal sample period is 0.01 s"));
}

TEST(Program, ExcitesThePlantThatIsSimulatedAndEvaluated) {
  const Scratch scratch;
  scratch.write("tiny.toml", kTinyExperiment);
  const auto simulate = scratch.run({"simulate", "tiny.toml", "--input", "1 + t", "-o", "run.csv"});
  ASSERT_EQ(simulate.exit_code, 0) << simulate.err;
  const std::string csv = scratch.read("run.csv");
  EXPECT_THAT(csv, StartsWith("trajectory,time,y,y_measured,x1,x2,u\n1,0,"));
  EXPECT_THAT(csv, HasSubstr(",1\n1,0.05,"));
  EXPECT_THAT(csv, HasSubstr(",1.05\n1,0.1,"));

  ASSERT_EQ(scratch.run({"train", "tiny.toml", "-o", "a", "-q"}).exit_code, 0);
  const auto norms = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {"evaluate",  "a/model.json", "--trajectories", "3",
                                          "--against", "ekf",          "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto run = scratch.run(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return nlohmann::json::parse(run.out)[0];
  };
  const auto alone = norms({}), excited = norms({"--input", "2*cos(12*t)"});
  EXPECT_TRUE(alone["excitation"].empty());
  EXPECT_EQ(excited["excitation"]["u"], "2*cos(12*t)");
  EXPECT_NE(alone["norm"], excited["norm"]);
  EXPECT_LT(excited["against"]["ekf"]["norm"].get<double>(), 0.1) << "the EKF knows u";
}

TEST(Program, ShippedExperimentsAreKnownByName) {
  const Scratch scratch;
  const auto simulate = scratch.run({"simulate", "van_der_pol", "-o", "x.csv"});
  EXPECT_EQ(simulate.exit_code, 0) << simulate.err;
  EXPECT_TRUE(scratch.has("x.csv"));
}

}  // namespace
}  // namespace nlo::trainer
