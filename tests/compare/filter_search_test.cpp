// SPDX-License-Identifier: MIT
#include "trainer/compare/filter_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/compare/plants.h"
#include "trainer/evaluation/estimator_words.h"
#include "trainer/filters/plant_equations.h"

namespace nlo::trainer {
namespace {

const FilterRow& row_named(std::string_view name) {
  for (const FilterRow& row : filter_table())
    if (row.name == name) return row;
  throw codegen::Error("no such filter");
}

TEST(FilterSearch, FindsTheKalmanFilterOfALinearPlant) {
  // dx/dt = -x / 2 with process noise that the filter as shipped does not know: the best there is has the covariance of
  // the Riccati equation, p- = phi^2 p + q, p = p- r / (p- + r).
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
    // 32 runs of some 100 independent stretches: 2 % in the norm; as much again for Q and R found on half of that.
    EXPECT_NEAR(norm(row, tuned.tuning), std::sqrt(p), 0.04 * std::sqrt(p)) << name;
    EXPECT_GT(norm(row, {}), 1.3 * std::sqrt(p)) << name << ", control: as shipped it trusts its model";
  }
}

TEST(FilterSearch, FindsAGateWhereThereAreOutliers) {
  Condition condition;
  condition.noise = parse_noise("gaussian:0.5+outliers:0.05:10");
  const Experiment experiment = test::van_der_pol(20.0);
  const ComparedRuns runs = compared_runs(experiment, condition, SeedStream::kValidation, 1, 1, 8);
  const FilterRow& row = row_named("ekf");
  const TunedFilter tuned = tune_filter(row, filter_context(experiment, condition.noise, {}), runs);
  EXPECT_LT(tuned.tuning.gate, 6.0);
  EXPECT_LT(tuned.evaluations, 120);
}

TEST(FilterSearch, FindsWhichEquationIsWrong) {
  // mu stands in the equation of x2 alone, and y = x1 is exact:
  // noise put on x1 too makes the filter worse than it need be.
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
      << "0.012 and 0.077 over 50 s; half of a run of 20 s is transient";
}

TEST(FilterSearch, TheFilterThatKnowsTheParameterIsUncertainFollowsIt) {
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

TEST(FilterTable, RefusesByNameWhatAPlantHasNoUseFor) {
  FilterContext context = filter_context(test::van_der_pol(), {}, {});
  EXPECT_EQ(row_named("joint_ekf").unfit(context), "no condition changes a parameter");
  EXPECT_EQ(row_named("high_gain").unfit(context), "");
  context.plant.ny = 2;
  EXPECT_EQ(row_named("high_gain").unfit(context), "a high-gain observer is of one output");
}

TEST(FilterTable, CountsWhatAStepCosts) {
  // f of Van der Pol's equation as it is written has six operations, h none.
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
  EXPECT_GT(ekf, 5 * 4 * 6) << "five points, four stages";
}

}  // namespace
}  // namespace nlo::trainer
