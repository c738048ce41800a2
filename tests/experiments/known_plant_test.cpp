// SPDX-License-Identifier: MIT
#include "trainer/experiments/known_plant.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/experiments/experiment_text.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/rollout/sampling.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

/// A pendulum whose logs list its channels in another order than its equations.
std::string both() {
  return kLogExperiment + R"toml(
[plant]
states = ["rate", "angle"]
state_wraps = [0.0, 6.283185307179586]
derivative = ["-9.81 * sin(angle)", "rate"]
output_names = ["angle"]
output_units = ["rad"]
output_wraps = [6.283185307179586]
outputs = ["angle"]
estimated = ["rate"]

[simulation]
horizon_s = 1.0
trajectories = 6
initial_low = [-1.0, -1.0]
initial_high = [1.0, 1.0]
noise = "none+quantised:0.01"
share = 0.25
)toml";
}

/// Logs for that experiment: three runs at rest.
Dataset logs_at_rest() {
  Dataset logs;
  logs.outputs = {{"angle", "rad", 2.0 * M_PI}};
  logs.states = {{"rate", "", 0.0}};
  logs.sample_period_s = 0.01;
  logs.uniform = true;
  for (int i = 0; i < 3; ++i)
    logs.trajectories.push_back({.source = "a.csv",
                                 .time_s = Eigen::VectorXd::LinSpaced(300, 0.0, 2.99),
                                 .outputs = Eigen::MatrixXd::Zero(1, 300),
                                 .states = Eigen::MatrixXd::Zero(1, 300),
                                 .weight = Eigen::VectorXd::Ones(300),
                                 .log = "a.csv"});
  return logs;
}

TEST(KnownPlant, SimulatedRunsHaveTheChannelsThePeriodAndTheNoiseOfTheLogs) {
  const Experiment experiment = parse_experiment(both(), "e.toml");
  Dataset all = logs_at_rest();
  add_simulated_runs(experiment, all);
  ASSERT_EQ(all.trajectories.size(), 9U);
  EXPECT_EQ(all.simulated_share, 0.25);
  for (std::size_t i = 3; i < all.trajectories.size(); ++i) {
    const Trajectory& run = all.trajectories[i];
    ASSERT_EQ(run.outputs.rows(), 1);
    ASSERT_EQ(run.states.rows(), 1);
    EXPECT_NEAR(run.time_s(1) - run.time_s(0), 0.01, 1e-12);
    // The rate is the derivative of the angle. Central differences of an angle quantised to .01 err by .01 / .1.
    for (Eigen::Index k = 5; k + 5 < run.samples(); k += 5) {
      const double slope = (run.outputs(0, k + 5) - run.outputs(0, k - 5)) / 0.1;
      EXPECT_NEAR(run.states(0, k), slope, 0.12) << "tolerance: quantisation .1 and curvature .02";
      EXPECT_NEAR(std::remainder(run.outputs(0, k), 0.01), 0.0, 1e-9);
    }
  }
}

TEST(KnownPlant, SimulatedRunsGiveTheirShareOfTheSegmentsOfAStep) {
  const auto simulated = [](const Experiment& experiment, const Dataset& dataset) {
    const TrainingData data(dataset);
    int count = 0;
    for (long step = 0; step < 100; ++step)
      for (const Segment& segment : draw_segments(experiment, data, step)) count += segment.run >= 3;
    return count;
  };
  Experiment experiment = parse_experiment(both(), "e.toml");
  experiment.training.trajectories_per_step = 40;
  Dataset all = logs_at_rest();
  EXPECT_EQ(simulated(experiment, all), 0);
  add_simulated_runs(experiment, all);
  EXPECT_NEAR(simulated(experiment, all), 1000, 5.0 * std::sqrt(4000 * 0.25 * 0.75)) << "five binomial deviations";
  all.simulated_share = 0.0;
  EXPECT_NEAR(simulated(experiment, all), 4000 * 606.0 / 1506.0, 5.0 * std::sqrt(4000 * 0.4 * 0.6))
      << "control: without a share, runs are drawn by their length";
}

TEST(KnownPlant, TextReadsBackToTheSameExperiment) {
  const Experiment experiment = parse_experiment(both(), "e.toml");
  ASSERT_TRUE(experiment.known);
  EXPECT_FALSE(experiment.plant);
  const Experiment again = parse_experiment(experiment.source_text, "again.toml");
  EXPECT_EQ(again.source_text, experiment.source_text);
  EXPECT_EQ(again.known->simulation.share, 0.25);
}

TEST(KnownPlant, RefusesAMismatchWithTheLogsAndNamesIt) {
  expect_rows(both(), {
                          {"estimated = [\"rate\"]", "estimated = [\"angle\"]", "e.toml:27",
                           "the logs have the state \"rate\", but [plant] does not; name its channels"},
                          {"output_units = [\"rad\"]", "output_units = [\"deg\"]", "e.toml:27",
                           "the logs have the output \"angle\" in rad, but [plant] does not; units and wraps"},
                          {"share = 0.25", "share = 1.0", "e.toml:43", "share is 1; it must be"},
                          {"initial_low = [-1.0, -1.0]", "initial_low = [-1.0]", "e.toml:40", "initial_low"},
                      });
  EXPECT_THAT(error_of(kPlantExperiment, {"simulation.share=0.5"}), HasSubstr("is for simulated runs with a [log]"));
}

}  // namespace
}  // namespace nlo::trainer
