// SPDX-License-Identifier: MIT
// Wrong input, one row each: the exit code and the words of the message, and no file may be made or changed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "tests/commands/program.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

struct BadInput {
  std::string name;
  std::vector<std::string> arguments;
  int exit_code;
  std::string message;
  std::string file = {}, text = {};  ///< a file to write first; it replaces the fixture's file of that name

  friend void PrintTo(const BadInput& row, std::ostream* out) { *out << row.name; }
};

BadInput experiment(std::string name, const std::string& old, const std::string& replacement, std::string message,
                    int exit_code = 2) {
  return {std::move(name), {"train", "bad.toml", "-o", "out"},     exit_code, std::move(message),
          "bad.toml",      with(kTinyExperiment, old, replacement)};
}

BadInput log_experiment(std::string name, const std::string& old, const std::string& replacement, std::string message) {
  return {std::move(name),
          {"train", "bad.toml", "--data", "logs", "-o", "out"},
          2,
          std::move(message),
          "bad.toml",
          with(kTinyLogExperiment, old, replacement)};
}

BadInput csv(std::string name, std::string text, std::string message) {
  return {std::move(name), {"train", "log.toml", "--data", "logs", "-o", "out"}, 2, std::move(message), "logs/a.csv",
          std::move(text)};
}

BadInput model(std::string name, std::string text, std::string message) {
  return {std::move(name), {"export", "bad.json", "-o", "out.h"}, 2, std::move(message), "bad.json", std::move(text)};
}

BadInput usage(std::string name, std::vector<std::string> arguments, std::string message, int exit_code = 2) {
  return {std::move(name), std::move(arguments), exit_code, std::move(message)};
}

std::string lines(const std::string& head, const std::string& line, int count) {
  std::string text = head;
  for (int i = 0; i < count; ++i) text += line;
  return text;
}

const std::vector<BadInput>& bad_inputs() {
  static const std::vector<BadInput> kRows = {
      // The command line
      usage("NoCommand", {}, "subcommand is required"),
      usage("UnknownCommand", {"trian", "tiny.toml"}, "unknown command \"trian\"; did you mean \"train\"?"),
      usage("UnknownOption", {"train", "tiny.toml", "--thread", "2"}, "did you mean \"--threads\"?"),
      usage("NoExperiment", {"train"}, "EXPERIMENT is missing"),
      usage("MissingExperiment", {"train", "nowhere.toml"}, "nowhere.toml: no such file"),
      usage("MisspeltShippedExperiment", {"train", "van_der_pole"}, "did you mean \"van_der_pol\"?"),
      usage("ExperimentIsADirectory", {"train", "logs"}, "logs: "),
      usage("SeedIsNoNumber", {"train", "tiny.toml", "--seed", "one"}, "--seed"),
      usage("SeedIsNegative", {"train", "tiny.toml", "--seed=-1"}, "--seed"),
      usage("ThreadsAreNegative", {"train", "tiny.toml", "--threads=-1"}, "threads is -1"),
      usage("DataForAPlant", {"train", "tiny.toml", "--data", "logs"}, "--data is for experiments with a [log]"),
      usage("NoModelToEvaluate", {"evaluate"}, "MODEL is required"),
      usage("NoOutputToExport", {"export", "model.json"}, "--output is required"),
      usage("ZeroTrajectoriesToEvaluate", {"evaluate", "model.json", "--trajectories", "0"}, "--trajectories"),
      usage("ZeroTrajectoriesToSimulate", {"simulate", "tiny.toml", "--trajectories", "0", "-o", "x.csv"},
            "--trajectories"),
      usage("BoxScaleIsZero", {"evaluate", "model.json", "--box-scale", "0"}, "--box-scale"),
      usage("BoxScaleIsNan", {"evaluate", "model.json", "--box-scale", "nan"}, "--box-scale"),
      usage("UnknownNoise", {"evaluate", "model.json", "--noise", "gausian:1"},
            "noise \"gausian:1\" is of an unknown kind"),
      usage("NoiseWithoutScale", {"evaluate", "model.json", "--noise", "uniform"}, "has no scale"),
      usage("NoiseIsNan", {"simulate", "tiny.toml", "-o", "x.csv", "--noise", "gaussian:nan"}, "not a number"),
      usage("DelayIsTheWrongWayRound", {"evaluate", "model.json", "--noise", "none+delay:3:1"},
            "has a minimum delay above its maximum: swap them"),
      usage("InputNoiseForAnObserverWithoutInputs", {"evaluate", "model.json", "--input-noise", "gaussian:1"},
            "model.json reads no inputs; leave the option out, or train with [excitation]"),
      usage("InputNoiseForLogs", {"evaluate", "log_model.json", "--data", "logs/a.csv", "--input-noise", "gaussian:1"},
            "--input-noise is only for simulated trajectories of a plant"),
      usage("InputForAPlantWithoutOne",
            {"simulate", "tiny.toml", "--set", "plant.model=\"sine_cosine\"", "--input", "1", "-o", "x.csv"},
            "plant sine_cosine has no input to excite; leave --input out"),
      usage("TooManyInputs", {"simulate", "tiny.toml", "--input", "t", "--input", "1", "-o", "x.csv"},
            "plant van_der_pol has 1 input (u), but --input gives 2"),
      usage("TooManyInputsToEvaluate", {"evaluate", "model.json", "--input", "t", "--input", "1"},
            "but --input gives 2"),
      usage("InputOfAnUnknownName", {"evaluate", "model.json", "--input", "cos(12*s)"},
            "input u \"cos(12*s)\": Unexpected token \"s\" at position 8; variables: t"),
      usage("InputIsBroken", {"simulate", "tiny.toml", "--input", "cos(12*t", "-o", "x.csv"}, "input u \"cos(12*t\": "),
      usage("InputIsEmpty", {"simulate", "tiny.toml", "--input", " ", "-o", "x.csv"}, "the expression is empty"),
      usage("InputWithoutValue", {"simulate", "tiny.toml", "--input", "1/t", "-o", "x.csv"},
            "input u \"1/t\" is not a finite number at t = 0 s", 1),
      usage("InputForLogs", {"evaluate", "log_model.json", "--data", "logs/a.csv", "--input", "t"},
            "--input is only for simulated trajectories of a plant"),
      usage("UnknownAlternative", {"evaluate", "model.json", "--against", "oracle"}, "--against"),
      usage("LogWithoutAPlantsStates", {"evaluate", "model.json", "--data", "logs/a.csv"},
            "has no column of x1, x2, so there is no truth for the evaluation"),
      usage("MissingColumns", {"evaluate", "model.json", "--data", "logs/a.csv", "--columns", "no.toml"}, "no.toml"),
      usage("ColumnsWithoutLogs", {"evaluate", "model.json", "--columns", "no.toml"}, "--data FILE..."),
      usage("NoTableOfColumns", {"evaluate", "model.json", "--data", "logs/a.csv", "--columns", "tiny.toml"},
            "tiny.toml:3: \"plant\" has no use in a file of columns"),
      usage(
          "ChangedModel", {"evaluate", "model.json", "--set", "observer.hold=rk4"},
          "--set observer.hold=rk4: a test can only change plant.KEY, simulation.KEY, excitation.KEY and feedback.KEY"),
      usage("ChangedPlantOfNoSuchParameter", {"evaluate", "model.json", "--set", "plant.parameters.nu=1.2"},
            "has no parameter \"nu\"; did you mean \"mu\"?"),
      usage("ChangedPlantOfNoSuchKey", {"evaluate", "model.json", "--set", "simulation.horizon=1"},
            "did you mean \"horizon_s\"?"),
      usage("TruePlantThatIsNotChanged", {"evaluate", "model.json", "--against", "ekf_true"}, "that --set changes"),
      usage("ModelsOfTwoExperiments", {"evaluate", "model.json", "log_model.json"},
            "log_model.json: was trained by another experiment than model.json"),
      usage("NoTestSets", {"evaluate", "model.json", "--seeds", "0"}, "--seeds"),
      usage("NoDataForALogModel", {"evaluate", "log_model.json"}, "--data FILE..."),
      usage("BoxScaleForLogs", {"evaluate", "log_model.json", "--data", "logs/a.csv", "--box-scale", "2"},
            "--box-scale is only for simulated trajectories of a plant"),
      usage("MissingLogToEvaluate", {"evaluate", "log_model.json", "--data", "logs/z.csv"}, "no file matches"),
      usage("NoModelToWatch", {"monitor"}, "MODEL is required"),
      usage("FalseAlarmsAreNone", {"monitor", "model.json", "--false-alarms-per-hour", "0"}, "--false-alarms-per-hour"),
      usage("MonitorOfALogModelWithoutLogs", {"monitor", "log_model.json"}, "name their directory: --data DIR"),
      usage("MonitorOfAPlantWithLogs", {"monitor", "model.json", "--data", "."}, "was trained on a simulated [plant]"),
      usage("MonitorOntoStdout", {"monitor", "model.json", "-o", "-"}, "stdout has the table; name a file"),
      usage("MonitorWithUnknownNoise", {"monitor", "model.json", "--noise", "pink:1"}, "pink"),
      usage("NoModelToCertify", {"certify"}, "MODEL is required"),
      usage("CertifyWithoutAGap", {"certify", "model.json", "--gap", "0"}, "--gap: Value 0 not in range"),
      usage("CertifyAnUnknownState", {"certify", "model.json", "--box", "q=-1:1"}, "the model has no state \"q\""),
      usage("CertifyAnEmptyRange", {"certify", "model.json", "--box", "x1=1:1"},
            "does not go from a smaller to a larger number"),
      usage("CertifyHalfABox", {"certify", "model.json", "--box", "x1=-1:1"}, "x2 has no range"),
      usage("CertifyWithGaussianNoise", {"certify", "model.json", "--noise", "gaussian:0.5"},
            "this noise is unbounded, but the proof needs bounded noise; write uniform:0.866"),
      usage("NegativeDisturbance", {"certify", "model.json", "--disturbance=-1"}, "--disturbance -1: must be"),
      usage("UnknownTarget", {"export", "model.json", "--target", "rust", "-o", "x"}, "unknown export target \"rust\""),
      usage("UnknownScalar", {"export", "model.json", "--scalar", "half", "-o", "x"}, "unknown scalar type \"half\""),
      usage("UnknownWeights", {"export", "model.json", "--weights", "half", "-o", "x"},
            "unknown type of weights \"half\"; there are float, bf16, fp16"),
      usage("HalfWeightsInDouble", {"export", "model.json", "--weights", "bf16", "--scalar", "double", "-o", "x"},
            "--weights bf16 needs --scalar float"),
      usage("HalfWeightsInC99", {"export", "model.json", "--weights", "fp16", "--target", "c99", "-o", "tiny.h"},
            "--weights fp16 is only for targets cpp and replay"),
      usage("ErrorOfHalfWeightsBeyondItsLimit",
            {"export", "model.json", "--weights", "bf16", "--max-error", "1e-9", "-o", "x.h"},
            "nothing is written. --weights float has an error of", 1),
      usage("ErrorBeyondItsLimit", {"export", "model.json", "--scalar", "int16", "--max-error", "1e-9", "-o", "x.h"},
            "nothing is written. --scalar float has an error of", 1),
      usage("LimitOfNoState", {"export", "model.json", "--max-error", "speed=1", "-o", "x.h"}, "there is no state"),
      usage("LimitIsNan", {"export", "model.json", "--max-error", "nan", "-o", "x.h"}, "give a positive number"),
      usage("NameIsAKeyword", {"export", "model.json", "--name", "class", "-o", "x"}, "not an identifier"),
      usage("NameIsAPath", {"export", "model.json", "--name", "../x", "-o", "x"}, "not an identifier"),
      usage("SimulateLogs", {"simulate", "log.toml", "-o", "x.csv"}, "has no [plant] to simulate"),

      // Output paths
      usage("OutputDirectoryIsAFile", {"train", "tiny.toml", "-o", "tiny.toml"}, "tiny.toml is a file"),
      usage("OutputBelowAFile", {"train", "tiny.toml", "-o", "tiny.toml/x"}, "tiny.toml is a file"),
      usage("OutputDirectoryCannotBeMade", {"train", "tiny.toml", "-o", std::string(300, 'x')},
            "cannot make the directory", 1),
      usage("AnotherExperimentsModel", {"train", "tiny.toml", "-o", "used"}, "holds the model of another experiment"),
      usage("NotAModelInTheWay", {"train", "tiny.toml", "-o", "strange"}, "--force"),
      usage("ModelWithoutACheckpoint", {"train", "tiny.toml", "-o", "bare", "--resume"},
            "there is no such file, so the training cannot be resumed"),
      {"DamagedCheckpoint",
       {"train", "tiny.toml", "-o", "half", "--resume"},
       2,
       "checkpoint.bin",
       "half/checkpoint.bin",
       "not a checkpoint"},
      usage("ReportOfNothing", {"report", "logs"}, "logs/model.json: "),
      usage("ReportOfLogsThatAreElsewhere", {"report", "log_run"}, "--data DIR"),
      usage("ExportBelowAFile", {"export", "model.json", "-o", "tiny.toml/such/x.h"}, "tiny.toml is a file"),
      usage("ExportOntoADirectory", {"export", "model.json", "-o", "logs"}, "logs: is a directory"),
      usage("SimulateIntoNowhere", {"simulate", "tiny.toml", "-o", "no/x.csv"}, "there is no directory no"),

      // Experiments
      experiment("EmptyExperiment", kTinyExperiment, "", "bad.toml: the experiment has no name"),
      experiment("UnknownKey", "eigenvalues", "eigen_values",
                 "bad.toml:14: unknown key \"eigen_values\" in [observer]; did you mean \"eigenvalues\"?"),
      experiment("BrokenToml", "steps = 20", "steps = = 20", "bad.toml:20: "),
      experiment("KeyTwice", "steps = 20", "steps = 20\nsteps = 21", "bad.toml:21: "),
      experiment("DeepNesting", "steps = 20", "steps = " + std::string(50000, '['), "nested more than"),
      experiment("TooBig", "steps = 20", "steps = 20 #" + std::string(2000000, 'x'), "bytes"),
      experiment("NotText", "steps = 20", std::string("steps = 2\0", 10), "byte 0x00 is not text"),
      experiment("NegativeSteps", "steps = 20", "steps = -1", "[training] steps is -1"),
      experiment("WidthZero", "hidden = [8]", "hidden = [0]", "hidden[0] is 0; it must be an integer from 1 to 1024"),
      experiment("PlantEscapes", "model = \"van_der_pol\"",
                 "states = [\"a\", \"b\"]\nderivative = [\"100*a\", \"b\"]\noutputs = [\"a\"]",
                 "plant expressions: a of the trajectory from x(0) = (", 1),
      usage("PastEscapes",
            {"train", "tiny.toml", "--set", "training.transient=\"backward\"", "--set",
             "simulation.initial_high=[6, 6]", "-o", "out"},
            "plant van_der_pol: backwards from x(0) = (", 1),
      usage("OverrideOfAnUnknownKey", {"train", "tiny.toml", "--set", "training.stepz=3", "-o", "out"},
            "--set training.stepz=3: unknown key \"stepz\" in [training]; did you mean \"steps\"?"),
      usage("OverrideWithoutValue", {"train", "tiny.toml", "--set", "training.steps", "-o", "out"}, "no KEY=VALUE"),
      usage("OverrideOutOfRange", {"train", "tiny.toml", "--set", "training.ema=2", "-o", "out"}, "ema is 2"),
      usage("OverrideIsBroken", {"train", "tiny.toml", "--set", "observer.eigenvalues=[-1", "-o", "out"},
            "--set observer.eigenvalues=[-1: "),

      // Logs
      usage("MissingDataDirectory", {"train", "log.toml", "--data", "nowhere", "-o", "out"},
            "nowhere: no such directory"),
      log_experiment("MissingLog", "a.csv", "z.csv", "no file matches \"z.csv\""),
      log_experiment("SameLogTwice", "b.csv", "a.csv", "list each log in only one split"),
      log_experiment("AngleThatCannotTurn", "unit = \"m\"\n", "unit = \"m\"\nwrap = 6.283185307179586\n",
                     "[observer] features is \"latent_and_output\""),
      log_experiment("CutoffAboveNyquist", "[[log.columns]]",
                     "[log.velocity_filter]\ncutoff_hz = 80.0\n\n[[log.columns]]", "cutoff_hz"),
      csv("EmptyLog", "", "logs/a.csv: the file is empty"),
      csv("HeaderOnly", "time,y\n", "there is a header but no data"),
      csv("RaggedRow", tiny_log() + "3.0\n", "a.csv:302: expected 2 cells as in the header, found 1"),
      csv("NanTime", with(tiny_log(), "0.5,", "nan,0.1\n0.505,"), "a.csv:52:time: \"nan\""),
      csv("WordInACell", with(tiny_log(), "0.5,", "0.5,high\n0.505,"), "a.csv:52:y: \"high\""),
      csv("InfiniteCell", with(tiny_log(), "0.5,", "0.5,inf\n0.505,"), "a.csv:52:y: \"inf\" is not finite"),
      csv("NoCellFilled", "time,y\n0,\n0.01,nan\n0.02,NA\n", "a.csv: no row has a value of \"y\""),
      csv("Utf16", std::string("\xFF\xFEt\0", 4), "a.csv: the file is UTF-16"),
      csv("HeaderIsAComment", with(tiny_log(), "time,y", "# time,y"), "delete its #"),
      csv("Gzip", std::string("\x1f\x8b\x08\0", 4), "a.csv: is compressed by gzip: gunzip"),
      log_experiment("SeparatorOfItsOwn", "[log]\n", "[log]\nseparator = \"|\"\n",
                     "[log] separator is \"|\"; use \",\", \";\", \"tab\", \"space\""),
      csv("TimeStandsStill", lines("time,y\n", "1,1\n", 99), "time does not increase"),
      csv("TooShortForTheFilter", tiny_log(0.0, 5), "a.csv"),

      // Models
      usage("MissingModel", {"export", "nowhere.json", "-o", "x.h"}, "nowhere.json: "),
      model("EmptyModel", "", "bad.json:1:1: the file is empty"),
      model("NotJson", "{\"format\": \"nlo-model\",", "bad.json:1:"),
      model("NotAModel", "{}", "no nlo model"),
      model("FutureModel", "{\"format\": \"nlo-model\", \"version\": 99}", "version"),
      model("DeepModel", std::string(100000, '['), "nests deeper"),
  };
  return kRows;
}

/// All files that the rows refer to, made once, because training takes most of the time.
class BadInputs : public testing::TestWithParam<BadInput> {
 protected:
  static void SetUpTestSuite() {
    made_ = new Scratch;
    made_->write("tiny.toml", kTinyExperiment);
    made_->write("log.toml", kTinyLogExperiment);
    made_->write("logs/a.csv", tiny_log(0.0));
    made_->write("logs/b.csv", tiny_log(1.0));
    made_->write("strange/model.json", "my notes");
    const auto plant = made_->run({"train", "tiny.toml", "-o", "plant_run", "-q"});
    ASSERT_EQ(plant.exit_code, 0) << plant.err;
    const auto logs = made_->run({"train", "log.toml", "--data", "logs", "-o", "log_run", "-q"});
    ASSERT_EQ(logs.exit_code, 0) << logs.err;
    made_->write("model.json", made_->read("plant_run/model.json"));
    made_->write("log_model.json", made_->read("log_run/model.json"));
    made_->write("used/model.json", made_->read("log_run/model.json"));
    made_->write("bare/model.json", made_->read("model.json"));
  }
  static void TearDownTestSuite() {
    delete made_;
    made_ = nullptr;
  }
  static Scratch* made_;
};
Scratch* BadInputs::made_ = nullptr;

TEST_P(BadInputs, IsRefusedWithTheRemedyAndChangesNoFile) {
  const BadInput& row = GetParam();
  const Scratch scratch;
  for (const auto& [file, text] : made_->contents())
    if (!file.ends_with('/')) scratch.write(file, text);
  if (!row.file.empty()) scratch.write(row.file, row.text);
  const auto before = scratch.contents();
  const ProgramResult result = scratch.run(row.arguments);
  EXPECT_EQ(result.exit_code, row.exit_code) << result.err;
  EXPECT_THAT(result.err, HasSubstr("nlo: error: "));
  EXPECT_THAT(result.err, HasSubstr(row.message));
  EXPECT_LE(result.err.size(), 2000u) << "a message must be short enough to read";
  EXPECT_EQ(result.out, "");
  EXPECT_TRUE(scratch.contents() == before) << "a file was made or changed";
}

INSTANTIATE_TEST_SUITE_P(Table, BadInputs, testing::ValuesIn(bad_inputs()),
                         [](const auto& row) { return row.param.name; });

TEST(BadInputTable, HasAtLeastFortyFiveRows) {
  EXPECT_GE(bad_inputs().size(), 45u);
}

}  // namespace
}  // namespace nlo::trainer
