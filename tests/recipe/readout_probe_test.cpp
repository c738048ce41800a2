// SPDX-License-Identifier: MIT
#include "trainer/recipe/readout_probe.h"

#include <gtest/gtest.h>

#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"

namespace nlo::trainer {
namespace {

/// x1' = x2, x2' = -x1, y = x1: linear, so that a linear readout of z is exact once the start is forgotten.
Experiment oscillator(const std::string& observer, const std::string& outputs = R"("a")") {
  return parse_experiment(R"(name = "oscillator"
[plant]
states = ["a", "b"]
derivative = ["b", "-a"]
output_names = ["y"]
outputs = [)" + outputs + R"(]
[simulation]
horizon_s = 40.0
sample_period_s = 0.05
trajectories = 40
initial_low = [-1.0, -1.0]
initial_high = [1.0, 1.0]
[observer]
output_injection = "unit_gain"
start = "steady"
)" + observer,
                          "o.toml");
}

ReadoutError error_of(const Experiment& experiment, const std::string& threads = "1") {
  Experiment threaded = experiment;
  threaded.threads = std::stoi(threads);
  const TrainingSets sets = simulate_training_sets(threaded);
  return ReadoutProbe(threaded, sets.training).error(threaded, 64, 4000);
}

TEST(ReadoutProbe, FindsALinearPlantInALinearReadout) {
  const ReadoutError fast = error_of(oscillator("eigenvalues = [-2.0, -4.0]"));
  const ReadoutError slow = error_of(oscillator("eigenvalues = [-0.02, -0.03]"));
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_LT(fast.linear[i], 0.2);                   // the transient alone: 2 of 40 s
    EXPECT_GT(slow.linear[i], 2.0 * fast.linear[i]);  // never forgets where it started
  }
  EXPECT_LT(fast.mean_log(), slow.mean_log());
}

TEST(ReadoutProbe, SeesThatACurvedPlantWantsACurvedReadout) {
  const ReadoutError line = error_of(oscillator("eigenvalues = [-2.0, -4.0]"));
  const ReadoutError curve = error_of(oscillator("eigenvalues = [-2.0, -4.0]", "\"exp(2*a)\""));
  EXPECT_LT(curve.curved[0], 0.6 * curve.linear[0]);
  EXPECT_LT(line.linear[0], curve.linear[0]);
}

TEST(ReadoutProbe, SaysThatAStateIsNotSeen) {
  const ReadoutError error = error_of(oscillator("eigenvalues = [-2.0, -4.0]", R"("0.0")"));
  for (const double share : error.linear) EXPECT_NEAR(share, 1.0, 0.05);
}

TEST(ReadoutProbe, GivesTheSameNumbersForAnyNumberOfThreads) {
  const Experiment experiment = oscillator("eigenvalues = [-2.0, -4.0]\n[training]\nnoise = \"gaussian:0.1\"");
  const ReadoutError one = error_of(experiment, "1"), three = error_of(experiment, "3");
  EXPECT_EQ(one.linear, three.linear);
  EXPECT_EQ(one.curved, three.curved);
}

}  // namespace
}  // namespace nlo::trainer
