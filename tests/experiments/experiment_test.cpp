// SPDX-License-Identifier: MIT
#include "trainer/config/experiment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(Config, ReadsWhatIsWritten) {
  const Experiment e = parse_experiment(kPlantExperiment, "e.toml");
  EXPECT_EQ(e.name, "small");
  ASSERT_TRUE(e.plant);
  EXPECT_EQ(e.plant->model, "van_der_pol");
  EXPECT_THAT(e.plant->parameters, ElementsAre(std::pair<std::string, double>("mu", 1.5)));
  EXPECT_EQ(e.simulation.horizon_s, 10.0);
  EXPECT_THAT(e.simulation.initial_low, ElementsAre(-1.0, -1.0));
  EXPECT_THAT(e.observer.eigenvalues, ElementsAre(-1.0, -2.0));
  EXPECT_THAT(e.observer.pairs, ElementsAre(std::array<double, 2>{-0.5, 1.0}));
  EXPECT_EQ(e.training.noise, (NoiseConfig{NoiseKind::kGaussian, 0.5}));
}

TEST(Config, LeavesTheDefaultsOfTheStruct) {
  const Experiment e = parse_experiment(kPlantExperiment, "e.toml");
  EXPECT_EQ(e.seed, Experiment{}.seed);
  EXPECT_EQ(e.inverse_map.hidden, InverseMapConfig{}.hidden);
  EXPECT_EQ(e.training.learning_rate, TrainingConfig{}.learning_rate);
}

TEST(Config, ReadsColumnsInOrder) {
  const Experiment e = parse_experiment(kLogExperiment, "e.toml");
  ASSERT_TRUE(e.log);
  ASSERT_EQ(e.log->columns.size(), 3u);
  EXPECT_EQ(e.log->columns[0].role, ColumnRole::kTime);
  EXPECT_EQ(e.log->columns[1].column, "angle");
  EXPECT_EQ(e.log->columns[1].wrap, 6.283185307179586);
  EXPECT_EQ(e.log->columns[2].derivative_of, "angle");
  EXPECT_EQ(e.log->columns[2].column, "");
}

TEST(Config, AWrapMayBeANumberOrDegrees) {
  EXPECT_EQ(parse_experiment(with(kLogExperiment, "\"2pi\"", "360"), "e.toml").log->columns[1].wrap, 360.0);
  EXPECT_EQ(parse_experiment(with(kLogExperiment, "\"2pi\"", "\"360deg\""), "e.toml").log->columns[1].wrap, 360.0);
}

TEST(Config, ItsTextReadsBackToTheSameExperiment) {
  for (const std::string& text :
       {kPlantExperiment, kLogExperiment,
        with(kPlantExperiment, "model = \"van_der_pol\"\nparameters = { mu = 1.5 }",
             "states = [\"a\", \"b\"]\nderivative = [\"b\", \"-a\"]\noutputs = [\"a\"]\noutput_units = [\"m \\\"x\\\" "
             "\\\\ µ\"]\ninputs = [\"u\"]\ninput_field = [[\"0\"], [\"1 + a\"]]")}) {
    const Experiment once = parse_experiment(text, "e.toml");
    const Experiment twice = parse_experiment(once.source_text, "source_text");
    EXPECT_EQ(once.source_text, twice.source_text);
    EXPECT_THAT(once.source_text, HasSubstr("name = "));
  }
}

TEST(Config, ItsTextHasEveryKeyThatDecidesTheRun) {
  Experiment e = parse_experiment(kPlantExperiment, "e.toml");
  const std::string before = e.source_text;
  e.threads = 7;
  EXPECT_EQ(format_experiment(e), before);  // decides nothing
  e.training.ema = 0.5;
  EXPECT_NE(format_experiment(e), before);
}

TEST(Config, TheShippedExperimentsAreValid) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(NLO_SOURCE_DIR "/trainer/experiments")) {
    if (entry.path().extension() != ".toml") continue;
    ++found;
    EXPECT_EQ(read_experiment(entry.path().string()).name, entry.path().stem().string());
  }
  EXPECT_GE(found, 2);
}

TEST(Config, WindowsOfTheEvaluationReadBackAndAreLeftOutWhenDerived) {
  const std::string windows =
      "[evaluation]\nwindows = [{ name = \"settled\", from_s = 2.5 }, "
      "{ name = \"early\", from_s = 0.5, to_s = 5 }]\n";
  const Experiment read = parse_experiment(kPlantExperiment + windows, "f");
  ASSERT_EQ(read.evaluation.windows.size(), 2U);
  EXPECT_EQ(read.evaluation.windows[0].from_s, 2.5);
  EXPECT_FALSE(std::isfinite(read.evaluation.windows[0].to_s));
  EXPECT_EQ(read.evaluation.windows[1].to_s, 5.0);
  EXPECT_EQ(parse_experiment(read.source_text, "again").source_text, read.source_text);
  EXPECT_EQ(parse_experiment(kPlantExperiment, "f").source_text.find("[evaluation]"), std::string::npos);
}

TEST(Config, HelpNamesEveryKeyOnce) {
  const std::string help = describe_experiment_keys();
  for (const char* key : {"eigenvalues", "horizon_s", "derivative_of", "cutoff_hz", "linear_path", "early_share"})
    EXPECT_THAT(help, HasSubstr(std::string("\n  ") + key + " ")) << key;
  EXPECT_THAT(help, HasSubstr("default \"first_order\""));
}

}  // namespace
}  // namespace nlo::trainer
