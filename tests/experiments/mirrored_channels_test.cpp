// SPDX-License-Identifier: MIT
// Tests which channels change their sign under [training] mirror.
#include "trainer/experiments/mirrored_channels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiments/experiment_text.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {
namespace {

using ::testing::ElementsAre;

TEST(Mirror, ChangesAllChannelsOfAPlantExceptThoseDeclaredEven) {
  const std::string lorenz =
      "name = \"e\"\n[plant]\nstates = [\"x1\", \"x2\", \"x3\"]\neven = [\"x3\"]\n"
      "derivative = [\"10 * (x2 - x1)\", \"x1 * (28 - x3) - x2\", \"x1 * x2 - 8 / 3 * x3\"]\n"
      "outputs = [\"x1\"]\n[simulation]\ninitial_low = [-1, -1, -1]\ninitial_high = [1, 1, 1]\n"
      "[observer]\neigenvalues = [-1.0]\n[training]\nmirror = ";
  EXPECT_THAT(mirrored_channels(parse_experiment(lorenz + "true\n", "e.toml")), ElementsAre("x1", "x2", "y"));
  EXPECT_TRUE(mirrored_channels(parse_experiment(lorenz + "false\n", "e.toml")).empty());
}

/// A computed output changes its sign if its expression is odd in the channels that change their sign.
TEST(Mirror, ChangesOddColumnsAndOddComputedOutputsOfLogs) {
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
  EXPECT_THAT(mirrored_channels(experiment), ElementsAre("theta", "u", "omega", "q"));
}

}  // namespace
}  // namespace nlo::trainer
