// SPDX-License-Identifier: MIT
#include "trainer/compare/filter_in_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "trainer/baselines/ekf.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/evaluation/closed_loop.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// An inverted pendulum about its upright: dx/dt = [0 1; 4 0] x + [0; 1] u; y = angle.
Experiment upright() {
  return parse_experiment(R"toml(name = "upright"
[plant]
states = ["angle", "rate"]
derivative = ["rate", "4*angle + u"]
outputs = ["angle"]
output_names = ["y"]
inputs = ["u"]
[simulation]
horizon_s = 2.0
sample_period_s = 0.02
trajectories = 8
initial_low = [-0.2, -0.2]
initial_high = [0.2, 0.2]
[feedback]
law = ["-(12*angle + 5*rate)"]
actuator_low = [-50]
actuator_high = [50]
cost = "4*angle^2 + 0.5*u^2"
[observer]
eigenvalues = [-4.0, -6.0, -9.0]
)toml",
                          "e.toml");
}

NoiseConfig noise_of(const std::string& text) {
  return parse_noise(text);
}

Dataset runs_of(const Experiment& e, const LoopEstimators& estimators) {
  return simulate_runs(e, *make_plant(*e.plant), initial_state_seed(3, SeedStream::kTest), 6, 1.0, {}, estimators);
}

TEST(FilterInLoop, IsTheFilterOverTheRunThatItMade) {
  // The law is linear, and so u says what the filter thought: on the same y a filter of another form thinks the same.
  const Experiment e = upright();
  const NoiseConfig noise = noise_of("gaussian:0.02");
  constexpr std::uint64_t kSeed = 11;
  const Dataset set = runs_of(e, with_noise(filter_in_loop("ekf", e, noise), noise, kSeed));
  const InitialMoments start = initial_moments(e.simulation);
  const FilterConfig config{start.mean, start.covariance, 1e-6, noise_variances(noise), {}, true};
  const auto plant = make_plant(*e.plant);
  const Estimator estimate = ekf_estimator(
      [&] {
        return FilterPlant{[&](const MatrixXd& x) { return plant->derivative(x); },
                           [&](const MatrixXd& x) { return plant->output(x); },
                           [&](const MatrixXd& x, const VectorXd& u) { return driven_derivative(*plant, x, u); }};
      },
      config)();
  double control = 0.0;
  for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
    const Trajectory& run = set.trajectories[i];
    const MatrixXd x_hat = estimate(MeasurementNoise(noise, kSeed, i).on(run.outputs), run.inputs, run.time_s);
    const MatrixXd other = estimate(MeasurementNoise(noise, kSeed + 1, i).on(run.outputs), run.inputs, run.time_s);
    for (Index k = 0; k + 1 < run.samples(); ++k) {
      // Central differences of a linear map over another width: rounding over 1e-4.
      ASSERT_NEAR(run.inputs(0, k + 1), -(12.0 * x_hat(0, k) + 5.0 * x_hat(1, k)), 1e-6);
      control = std::max(control, std::abs(run.inputs(0, k + 1) + 12.0 * other(0, k) + 5.0 * other(1, k)));
    }
  }
  EXPECT_GT(control, 0.1) << "control: other noise, other thoughts";
}

TEST(FilterInLoop, RefusesANameThatIsNoFilters) {
  const Experiment e = upright();
  EXPECT_THROW(filter_in_loop("oracle", e, noise_of("none")), codegen::Error);
}

TEST(LoopCosts, AreTheMeanOfTheExpression) {
  const Experiment e = upright();
  Dataset set = runs_of(e, nullptr);
  double sum = 0.0;
  Index samples = 0;
  for (const Trajectory& run : set.trajectories) {
    sum += 4.0 * run.states.row(0).squaredNorm() + 0.5 * run.inputs.squaredNorm();
    samples += run.samples();
  }
  const auto plant = make_plant(*e.plant);
  EXPECT_NEAR(mean_cost(e, *plant, set).value(), sum / static_cast<double>(samples), 1e-12);  // another order of sums
  Experiment without = e;
  without.feedback->cost.clear();
  EXPECT_FALSE(mean_cost(without, *plant, set));
}

TEST(LoopCosts, OfANoisierSensorAreHigher) {
  const Experiment e = upright();
  const auto plant = make_plant(*e.plant);
  const auto cost = [&](const std::string& text) {
    const NoiseConfig noise = noise_of(text);
    return mean_cost(e, *plant, runs_of(e, with_noise(filter_in_loop("ekf", e, noise), noise, 5))).value();
  };
  const double of_true_state = mean_cost(e, *plant, runs_of(e, nullptr)).value();
  EXPECT_LT(of_true_state, cost("gaussian:0.01"));
  EXPECT_LT(cost("gaussian:0.01"), cost("gaussian:0.1"));
}

}  // namespace
}  // namespace nlo::trainer
