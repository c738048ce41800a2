// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/table_filter.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "codegen/base/error.h"
#include "tests/compare/plants.h"
#include "tests/evaluation/van_der_pol_set.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/judge/evaluation/closed_loop.h"
#include "trainer/judge/evaluation/estimator_words.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// An inverted pendulum about its upright position: dx/dt = [0 1; 4 0] x + [0; 1] u; y = angle.
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

// Reference values from an independent prototype with the exact model, Q = 1e-6, 200 runs of 50 s. The tolerance covers
// another draw of initial states and noise; the first second dominates the error.
struct Reference {
  NoiseConfig noise;
  double norm, tolerance;
};

class EkfReference : public testing::TestWithParam<Reference> {};

TEST_P(EkfReference, AgreesWithTheTableOfTheProtocol) {
  const auto& [noise, norm, tolerance] = GetParam();
  const Dataset set = test::van_der_pol_set(200, 50.0, 5);
  const Evaluation found = evaluate("ekf", table_filter("ekf", test::van_der_pol(), noise, false), set, noise, 11, 0);
  EXPECT_NEAR(found.metrics.norm, norm, tolerance * norm);
}

INSTANTIATE_TEST_SUITE_P(VanDerPol, EkfReference,
                         testing::Values(Reference{{}, 0.0148, 0.10},
                                         Reference{{NoiseKind::kGaussian, 0.5}, 0.0944, 0.10},
                                         Reference{{NoiseKind::kUniform, 3.0}, 0.2222, 0.10}));

TEST(FilterInLoop, EqualsTheFilterOverTheRecordedRun) {
  // The law is linear, so u shows the estimate of the filter.
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
      // Steps here are differences of time stamps, with rounding.
      ASSERT_NEAR(run.inputs(0, k + 1), -(12.0 * x_hat(0, k) + 5.0 * x_hat(1, k)), 1e-9);
      control = std::max(control, std::abs(run.inputs(0, k + 1) + 12.0 * other(0, k) + 5.0 * other(1, k)));
    }
  }
  EXPECT_GT(control, 0.1) << "control: other noise gives other estimates";
}

TEST(FilterInLoop, RefusesAnUnknownFilter) {
  const Experiment e = upright();
  EXPECT_THROW(filter_in_loop("oracle", e, noise_of("none")), codegen::Error);
}

TEST(LoopCosts, AreTheMeanOfTheCostExpression) {
  const Experiment e = upright();
  Dataset set = runs_of(e, nullptr);
  double sum = 0.0;
  Index samples = 0;
  for (const Trajectory& run : set.trajectories) {
    sum += 4.0 * run.states.row(0).squaredNorm() + 0.5 * run.inputs.squaredNorm();
    samples += run.samples();
  }
  const auto plant = make_plant(*e.plant);
  EXPECT_NEAR(mean_cost(e, *plant, set).value(), sum / static_cast<double>(samples), 1e-12);  // summed in another order
  Experiment without = e;
  without.feedback->cost.clear();
  EXPECT_FALSE(mean_cost(without, *plant, set));
}

TEST(LoopCosts, IncreaseWithTheNoiseOfTheSensor) {
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

const FilterRow& row_named(std::string_view name) {
  for (const FilterRow& row : filter_table())
    if (row.name == name) return row;
  throw codegen::Error("no such filter");
}

TEST(FilterSearch, FindsTheKalmanFilterOfALinearPlant) {
  // dx/dt = -x / 2 with process noise that the untuned filter does not know. The best possible filter has the
  // covariance of the Riccati equation, p- = phi^2 p + q, p = p- r / (p- + r).
  Experiment experiment = parse_experiment(
      "name = \"linear\"\n[plant]\nstates = [\"x\"]\nderivative = [\"-a * x\"]\noutput_names = [\"y\"]\noutputs = "
      "[\"x\"]\n"
      "parameters = { a = 0.5 }\n[simulation]\nhorizon_s = 100.0\nsample_period_s = 0.1\ninitial_low = [-1.0]\n"
      "initial_high = [1.0]\n[observer]\neigenvalues = [-1.0, -2.0]\n",
      "linear.toml");
  experiment = nominal_experiment(experiment);
  Condition condition;
  condition.noise = parse_noise("gaussian:0.4");
  condition.process_noise = {0.5};
  const ComparedRuns tuning = compared_runs(experiment, condition, SeedStream::kValidation, 1, 1, 16);
  const FilterContext context = filter_context(experiment, condition.noise, {"a"});
  const double phi = std::exp(-0.05), q = 0.25 * 0.1, r = 0.16;
  const double b = r * (1.0 - phi * phi) + q, p = (-b + std::sqrt(b * b + 4.0 * phi * phi * q * r)) / (2.0 * phi * phi);

  const ComparedRuns test = compared_runs(experiment, condition, SeedStream::kTest, 1, 4, 8);
  const auto norm = [&](const FilterRow& row, const FilterTuning& tuning_of_row) {
    const auto filter = row.make(context, {tuning_of_row}, test.measured.lanes());
    return std::sqrt(squared_errors(*filter, test.measured, test).mean());
  };
  for (const char* name : {"ekf", "ukf"}) {
    const FilterRow& row = row_named(name);
    const TunedFilter tuned = tune_filter(row, context, tuning);
    // 32 runs of about 100 independent pieces: 2 % in the norm. The tolerance is twice that, because Q and R are found
    // from half of the data.
    EXPECT_NEAR(norm(row, tuned.tuning), std::sqrt(p), 0.04 * std::sqrt(p)) << name;
    EXPECT_GT(norm(row, {}), 1.3 * std::sqrt(p)) << name << ", control: the untuned filter trusts its model too much";
  }
}

TEST(FilterSearch, FindsAGateIfThereAreOutliers) {
  Condition condition;
  condition.noise = parse_noise("gaussian:0.5+outliers:0.05:10");
  const Experiment experiment = test::van_der_pol(20.0);
  const ComparedRuns runs = compared_runs(experiment, condition, SeedStream::kValidation, 1, 1, 8);
  const FilterRow& row = row_named("ekf");
  const TunedFilter tuned = tune_filter(row, filter_context(experiment, condition.noise, {}), runs);
  EXPECT_LT(tuned.tuning.gate, 6.0);
  EXPECT_LT(tuned.evaluations, 120);
}

TEST(FilterSearch, PutsProcessNoiseOnTheEquationThatIsWrong) {
  // mu occurs only in the equation of x2, and y = x1 is exact. Process noise on x1 as well would make the filter worse
  // than necessary.
  Condition condition;
  condition.parameters = {{"mu", 1.2}};
  const Experiment experiment = test::van_der_pol(20.0);
  const ComparedRuns tuning = compared_runs(experiment, condition, SeedStream::kValidation, 1, 1, 8),
                     runs = compared_runs(experiment, condition, SeedStream::kTest, 1, 1, 8);
  const FilterContext context = filter_context(experiment, condition.noise, {});
  FilterRow whole = row_named("ekf");
  whole.factors = [](const FilterContext& c) {
    auto factors = row_named("ekf").factors(c);
    std::erase_if(factors, [](const TunedFactor& factor) { return factor.name.starts_with("Q of "); });
    return factors;
  };
  const auto norm = [&](const FilterRow& row) {
    const auto filter = row.make(context, {tune_filter(row, context, tuning).tuning}, runs.measured.lanes());
    return std::sqrt(squared_errors(*filter, runs.measured, runs).mean());
  };
  EXPECT_LT(norm(row_named("ekf")), 0.4 * norm(whole))
      << "measured over 50 s: 0.012 and 0.077; here half of a run of 20 s is transient";
}

TEST(FilterSearch, JointFilterFollowsAnUncertainParameter) {
  Condition condition;
  condition.noise = parse_noise("gaussian:0.1");
  condition.parameter_factor = 1.2;
  const Experiment experiment = test::van_der_pol(50.0);
  const ComparedRuns runs = compared_runs(experiment, condition, SeedStream::kTest, 1, 1, 8);
  const FilterContext context = filter_context(experiment, condition.noise, {"mu"});
  const auto norm = [&](const char* name) {
    const auto filter = row_named(name).make(context, {{}}, runs.measured.lanes());
    return std::sqrt(squared_errors(*filter, runs.measured, runs).mean());
  };
  EXPECT_LT(norm("joint_ekf"), 0.5 * norm("ekf"));
}

TEST(FilterTable, RefusesAFilterThatDoesNotFitThePlant) {
  FilterContext context = filter_context(test::van_der_pol(), {}, {});
  EXPECT_EQ(row_named("joint_ekf").unfit(context), "no condition changes a parameter");
  EXPECT_EQ(row_named("high_gain").unfit(context), "");
  context.plant.ny = 2;
  EXPECT_EQ(row_named("high_gain").unfit(context), "a high-gain observer needs exactly one output");
}

TEST(FilterTable, CountsTheCostOfAStep) {
  // f of the Van der Pol equation has six operations as it is written, h has none.
  PlantConfig config;
  config.model = "van_der_pol";
  EXPECT_EQ(plant_cost(config).f.operations, 6.0);
  EXPECT_EQ(plant_cost(config).h.operations, 0.0);
  const FilterContext context = filter_context(test::van_der_pol(), {}, {"mu"});
  double ekf = 0.0;
  for (const FilterRow& row : filter_table()) {
    const double own = row.cost(context, plant_cost(config)).operations;
    if (ekf == 0.0) ekf = own;
    EXPECT_GE(own, ekf) << row.name << ": the EKF is the cheapest";
    EXPECT_GT(row.state(context), 0) << row.name;
    EXPECT_NE(estimator_words(row.name), nullptr) << row.name;
  }
  EXPECT_GT(ekf, 5 * 4 * 6) << "five sigma points, four stages";
}

}  // namespace
}  // namespace nlo::trainer
