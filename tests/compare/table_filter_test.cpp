// SPDX-License-Identifier: MIT
#include "trainer/compare/table_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "tests/compare/plants.h"
#include "tests/evaluation/van_der_pol_set.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/evaluation/closed_loop.h"
#include "trainer/experiments/load_experiment.h"
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

// What an independent prototype measured with the exact model, Q = 1e-6, 200 runs of 50 s: the reference values of the
// protocol. The band covers another draw of the initial states and of the noise, which the first second dominates.
struct Reference {
  NoiseConfig noise;
  double norm, tolerance;
};

class EkfReference : public testing::TestWithParam<Reference> {};

TEST_P(EkfReference, MeetsTheProtocolsTable) {
  const auto& [noise, norm, tolerance] = GetParam();
  const Dataset set = test::van_der_pol_set(200, 50.0, 5);
  const Evaluation found = evaluate("ekf", table_filter("ekf", test::van_der_pol(), noise, false), set, noise, 11, 0);
  EXPECT_NEAR(found.metrics.norm, norm, tolerance * norm);
}

INSTANTIATE_TEST_SUITE_P(VanDerPol, EkfReference,
                         testing::Values(Reference{{}, 0.0148, 0.10},
                                         Reference{{NoiseKind::kGaussian, 0.5}, 0.0944, 0.10},
                                         Reference{{NoiseKind::kUniform, 3.0}, 0.2222, 0.10}));

TEST(FilterInLoop, IsTheFilterOverTheRunThatItMade) {
  // The law is linear, and so u says what the filter thought.
  const Experiment e = upright();
  const NoiseConfig noise = noise_of("gaussian:0.02");
  constexpr std::uint64_t kSeed = 11;
  const Dataset set = runs_of(e, with_noise(filter_in_loop("ekf", e, noise), noise, kSeed));
  const Estimator estimate = table_filter("ekf", e, noise, true)();
  double control = 0.0;
  for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
    const Trajectory& run = set.trajectories[i];
    const MatrixXd x_hat = estimate(MeasurementNoise(noise, kSeed, i).on(run.outputs), run.inputs, run.time_s).x_hat;
    const MatrixXd other =
        estimate(MeasurementNoise(noise, kSeed + 1, i).on(run.outputs), run.inputs, run.time_s).x_hat;
    for (Index k = 0; k + 1 < run.samples(); ++k) {
      // Steps are differences of time stamps here: rounding.
      ASSERT_NEAR(run.inputs(0, k + 1), -(12.0 * x_hat(0, k) + 5.0 * x_hat(1, k)), 1e-9);
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
