// SPDX-License-Identifier: MIT
// What [training] mirror means, and what training is told of the symmetries of an experiment.
#include "trainer/experiments/symmetries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiments/experiment_text.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

using ::testing::ElementsAre;

TEST(Symmetries, AMirrorTurnsAllChannelsOfAPlantButThoseDeclaredEven) {
  const std::string lorenz =
      "name = \"e\"\n[plant]\nstates = [\"x1\", \"x2\", \"x3\"]\neven = [\"x3\"]\n"
      "derivative = [\"10 * (x2 - x1)\", \"x1 * (28 - x3) - x2\", \"x1 * x2 - 8 / 3 * x3\"]\n"
      "outputs = [\"x1\"]\n[simulation]\ninitial_low = [-1, -1, -1]\ninitial_high = [1, 1, 1]\n"
      "[observer]\neigenvalues = [-1.0]\n[training]\nmirror = ";
  const std::vector<SymmetryConfig> all = symmetries_of(parse_experiment(lorenz + "true\n", "e.toml"));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].kind, "sign");
  EXPECT_THAT(all[0].channels, ElementsAre("x1", "x2", "y"));
  EXPECT_TRUE(symmetries_of(parse_experiment(lorenz + "false\n", "e.toml")).empty());
}

/// Computed outputs turn as what they are computed of: an odd one is named, one of odd and even parts is not.
TEST(Symmetries, AMirrorOfLogsTurnsColumnsThatAreOddAndWhatIsComputedOfThem) {
  const Experiment experiment = parse_experiment(R"toml(name = "e"
[log]
sample_period_s = 0.01
train_files = ["a.csv"]
columns = [
  { name = "theta", role = "output", wrap = "2pi", encoding = "sincos" },
  { name = "v", role = "output", odd = false },
  { name = "u", role = "input" },
  { name = "omega", role = "state" },
  { name = "moving", role = "mask" },
  { name = "p", role = "output", expression = "theta_sin * u" },
  { name = "q", role = "output", expression = "v * u^3" },
  { name = "r", role = "output", expression = "v + u" },
]
[observer]
eigenvalues = [-1.0]
[training]
mirror = true
)toml",
                                                 "e.toml");
  EXPECT_THAT(symmetries_of(experiment).at(0).channels, ElementsAre("theta", "u", "omega", "q"));
}

TEST(Symmetries, AreWrittenAndReadBackAndNotTakenWhereTheStructureHasThem) {
  const std::string rotor =
      "name = \"e\"\n[plant]\nstates = [\"theta\", \"omega\"]\nstate_wraps = [\"2pi\", 0]\n"
      "estimated = [\"omega\"]\nderivative = [\"omega\", \"sin(3 * theta)\"]\n"
      "output_names = [\"angle\"]\noutputs = [\"theta\"]\noutput_wraps = [\"2pi\"]\n[simulation]\n"
      "initial_low = [-1, -1]\ninitial_high = [1, 1]\n[observer]\neigenvalues = [-1.0]\n"
      "output_injection = \"unit_gain\"\nstart = \"steady\"\nfeatures = \"latent_minus_output\"\n"
      "[[symmetry]]\nkind = \"shift\"\nchannels = [\"theta\", \"angle\"]\nfold = 3\n"
      "by_construction = ";
  const Experiment taken = parse_experiment(rotor + "false\n", "e.toml");
  ASSERT_EQ(symmetries_of(taken).size(), 1U);
  const Experiment again = parse_experiment(taken.source_text, "again.toml");
  EXPECT_EQ(again.source_text, taken.source_text);
  EXPECT_EQ(symmetries_of(again).at(0).fold, 3);
  const Experiment had = parse_experiment(rotor + "true\n", "e.toml");
  EXPECT_TRUE(symmetries_of(had).empty());
  EXPECT_TRUE(parse_experiment(had.source_text, "again.toml").symmetries.at(0).by_construction);
}

}  // namespace
}  // namespace nlo::trainer
