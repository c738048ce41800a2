// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "codegen/base/error.h"
#include "codegen/replay/reference_observer.h"
#include "tests/evaluation/van_der_pol_set.h"
#include "tests/support/row_of.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/judge/evaluation/closed_loop.h"
#include "trainer/judge/evaluation/evaluation_text.h"

namespace nlo::trainer {
namespace {

const NoiseConfig kGaussian{NoiseKind::kGaussian, 0.5}, kUniform{NoiseKind::kUniform, 3.0};

/// An observer with known results: one latent state z with dz/dt = -2 z + 2 y, and x_hat = (z, y).
codegen::Model low_pass_model() {
  codegen::Model model;
  model.name = "low_pass";
  model.outputs = {{"y", "", 0.0}};
  model.states = {{"x1", "", 0.0}, {"x2", "", 0.0}};
  model.sample_period_s = 0.02;
  codegen::linear_latent(model)->eigenvalues = Eigen::VectorXd::Constant(1, -2.0);
  codegen::linear_latent(model)->output_injection = Eigen::MatrixXd::Constant(1, 1, 2.0);
  model.initial_latent = Eigen::VectorXd::Zero(1);
  model.output_min = Eigen::VectorXd::Constant(1, -100.0);
  model.output_max = Eigen::VectorXd::Constant(1, 100.0);
  model.latent_min = Eigen::VectorXd::Constant(1, -100.0);
  model.latent_max = Eigen::VectorXd::Constant(1, 100.0);
  codegen::inverse_map(model)->features = Eigen::MatrixXd::Identity(2, 2);
  codegen::inverse_map(model)->feature_mean = Eigen::VectorXd::Zero(2);
  codegen::inverse_map(model)->feature_scale = Eigen::VectorXd::Ones(2);
  codegen::inverse_map(model)->layers = {{Eigen::MatrixXd::Identity(2, 2), Eigen::VectorXd::Zero(2)}};
  codegen::inverse_map(model)->output_mean = Eigen::VectorXd::Zero(2);
  codegen::inverse_map(model)->output_scale = Eigen::VectorXd::Ones(2);
  return model;
}

Estimator echo_first_output() {
  return [](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd&, const Eigen::VectorXd&) {
    return Eigen::MatrixXd(outputs.row(0).replicate(2, 1));
  };
}

TEST(Evaluate, GivesTheSameBytesForAnyNumberOfThreads) {
  const Dataset set = test::van_der_pol_set(13, 12.0, 3);
  const Evaluation one = evaluate_on_plant(low_pass_model(), set, kGaussian, 7, 1);
  for (const int threads : {2, 3, 8}) {
    const Evaluation many = evaluate_on_plant(low_pass_model(), set, kGaussian, 7, threads);
    EXPECT_EQ(evaluation_json(row_of("m", {one}), 1.0), evaluation_json(row_of("m", {many}), 1.0));
    EXPECT_EQ(one.metrics.curve, many.metrics.curve);
    ASSERT_EQ(one.examples.size(), many.examples.size());
    for (std::size_t i = 0; i < one.examples.size(); ++i)
      EXPECT_EQ(one.examples[i].estimate, many.examples[i].estimate);
  }
}

TEST(Evaluate, NoiseDependsOnTheSeed) {
  const Dataset set = test::van_der_pol_set(4, 2.0, 3);
  const double a = evaluate_on_plant(low_pass_model(), set, kGaussian, 1, 1).metrics.norm;
  EXPECT_EQ(a, evaluate_on_plant(low_pass_model(), set, kGaussian, 1, 1).metrics.norm);
  EXPECT_NE(a, evaluate_on_plant(low_pass_model(), set, kGaussian, 2, 1).metrics.norm);
}

TEST(Evaluate, EstimatorThatReturnsTheMeasurementHasTheErrorOfTheNoise) {
  // x_hat_1 = y, so the RMSE of x1 is the standard deviation of the noise. Five standard errors from 20 x 601 draws are
  // 5 / sqrt(2 * 12,020) = 3.2 % (Gaussian; less for uniform noise).
  const Dataset set = test::van_der_pol_set(20, 12.0, 3);
  for (const NoiseConfig& noise : {kGaussian, kUniform}) {
    const double deviation = noise.of(0).kind == NoiseKind::kGaussian ? 0.5 : std::sqrt(3.0);
    const Evaluation result = evaluate("echo", echo_first_output, set, noise, 5, 1);
    EXPECT_NEAR(result.metrics.per_component[0], deviation, 0.033 * deviation);
  }
  EXPECT_EQ(evaluate("echo", echo_first_output, set, {}, 5, 1).metrics.per_component[0], 0.0);
}

TEST(Evaluate, NamesTheRunWithTheLargestNorm) {
  const Dataset set = test::van_der_pol_set(9, 2.0, 3);
  const auto zero = []() -> Estimator {
    return [](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd&, const Eigen::VectorXd&) {
      return Eigen::MatrixXd(Eigen::MatrixXd::Zero(2, outputs.cols()));
    };
  };
  std::vector<double> norms;
  for (const Trajectory& run : set.trajectories) norms.push_back(std::sqrt(run.states.colwise().squaredNorm().mean()));
  const Evaluation result = evaluate("zero", zero, set, {}, 5, 2);
  const auto largest = std::max_element(norms.begin(), norms.end());
  EXPECT_NEAR(result.worst, *largest, 1e-12);  // rounding
  EXPECT_EQ(result.worst_run, static_cast<std::size_t>(largest - norms.begin()));
}

TEST(Evaluate, EstimatorReadsNoNoiseFreeValue) {
  // Each run reaches the estimator once, and none of its samples is noise-free.
  const Dataset set = test::van_der_pol_set(6, 2.0, 3);
  std::atomic<int> calls = 0, clean = 0;
  const auto spy = [&]() -> Estimator {
    return [&](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd&, const Eigen::VectorXd&) {
      ++calls;
      for (const Trajectory& run : set.trajectories)
        clean += static_cast<int>((run.outputs.array() == outputs.array()).count());
      return Eigen::MatrixXd(Eigen::MatrixXd::Zero(2, outputs.cols()));
    };
  };
  evaluate("spy", spy, set, kGaussian, 5, 2);
  EXPECT_EQ(calls, 6);
  EXPECT_EQ(clean, 0);
  evaluate("spy", spy, set, {}, 5, 2);
  EXPECT_GT(clean, 0);  // control: without noise, noise-free samples are detected
}

TEST(Evaluate, EstimatorReadsTheInputsWithoutNoise) {
  Dataset set = test::van_der_pol_set(5, 2.0, 3);
  for (Trajectory& run : set.trajectories) run.inputs = run.time_s.transpose().array().cos().matrix();
  std::atomic<int> calls = 0, right = 0;
  const auto spy = [&]() -> Estimator {
    return [&](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs, const Eigen::VectorXd&) {
      ++calls;
      right += inputs == set.trajectories[0].inputs ? 1 : 0;
      return Eigen::MatrixXd(Eigen::MatrixXd::Zero(2, outputs.cols()));
    };
  };
  evaluate("spy", spy, set, kGaussian, 5, 2);
  EXPECT_EQ(calls, 5);
  EXPECT_EQ(right, 5);
}

TEST(Evaluate, ObserverRunsInFloatAsInFlight) {
  const Dataset set = test::van_der_pol_set(1, 5.0, 3);
  const Trajectory& run = set.trajectories[0];
  const Eigen::MatrixXd estimate = observer_estimator(low_pass_model(), true)()(run.outputs, {}, run.time_s).x_hat;
  EXPECT_EQ(estimate, estimate.cast<float>().cast<double>());
  // z follows dz/dt = -2 z + 2 y with a first-order hold: closed form in double.
  const double h = 0.02, a = std::exp(-2.0 * h), b1 = 1.0 - (1.0 - a) / (2.0 * h), b0 = 1.0 - a - b1;
  double z = 0.0;
  for (Eigen::Index k = 1; k < run.samples(); ++k) {
    z = a * z + b0 * run.outputs(0, k - 1) + b1 * run.outputs(0, k);
    ASSERT_NEAR(estimate(0, k), z, 1e-5) << k;  // float: 250 steps, each rounding values up to 2 by 6e-8
  }
}

TEST(Evaluate, AStaticRidgeIsBetterThanTheMeanAndHoldsMissingSamples) {
  const Dataset set = test::van_der_pol_set(10, 20.0, 3), other = test::van_der_pol_set(5, 20.0, 4);
  const NoiseConfig noise = parse_noise("gaussian:0.1+missing:0.2");
  const auto norm = [&](const char* name) {  // throws if an estimate is NaN
    return evaluate(name, baseline_estimator(name, with_noise(set, noise, 5)), other, noise, 1, 1).metrics.norm;
  };
  EXPECT_LT(norm("static_ridge"), 0.9 * norm("constant"));
}

TEST(Evaluate, ErrorOfTheConstantIsTheStandardDeviationOfTheStates) {
  const Dataset set = test::van_der_pol_set(5, 20.0, 3);
  const Evaluation result = evaluate("constant", baseline_estimator("constant", set), set, kGaussian, 1, 1);
  double mean = 0.0, square = 0.0, n = 0.0;
  for (const Trajectory& run : set.trajectories) {
    mean += run.states.row(1).sum();
    square += run.states.row(1).squaredNorm();
    n += static_cast<double>(run.samples());
  }
  EXPECT_NEAR(result.metrics.per_component[1], std::sqrt(square / n - mean * mean / n / n), 1e-10);  // rounding
}

TEST(Evaluate, CountsTheDomainAndTheFirstSampleSeparately) {
  const Dataset set = test::van_der_pol_set(5, 20.0, 3);
  codegen::Model model = low_pass_model();
  const DomainShare all = evaluate_on_plant(model, set, {}, 1, 2).domain.value();
  EXPECT_EQ(all.share(), 1.0);
  EXPECT_EQ(all.samples, 5 * 1000);
  EXPECT_EQ(all.first_inside, 5);
  model.latent_min.setConstant(0.5);  // z starts at 0 and moves to both sides
  const DomainShare half = evaluate_on_plant(model, set, {}, 1, 2).domain.value();
  EXPECT_GT(half.share(), 0.2);
  EXPECT_LT(half.share(), 0.5);
  EXPECT_EQ(half.first_inside, 0);
}

TEST(Evaluate, RidgeOnTheFeaturesIsTheBestLinearEstimate) {
  // T* reads z and y, and x1 = y: the readout reproduces x1 exactly, except for the ridge. No linear function of z and
  // y gives x2.
  const Dataset set = test::van_der_pol_set(10, 20.0, 3), other = test::van_der_pol_set(5, 20.0, 4);
  const Evaluation ridge = evaluate("ridge", readout_estimator(low_pass_model(), set, 0.0), other, {}, 1, 2);
  EXPECT_LT(ridge.metrics.per_component[0], 1e-4);
  EXPECT_GT(ridge.metrics.per_component[1], 0.05);
  const Evaluation constant = evaluate("constant", baseline_estimator("constant", set), other, {}, 1, 1);
  EXPECT_LT(ridge.metrics.per_component[1], constant.metrics.per_component[1]);
}

TEST(Evaluate, StatesOfDifferentUnitsHaveANormalisedNorm) {
  Dataset set = test::van_der_pol_set(3, 20.0, 3);
  EXPECT_FALSE(evaluate("constant", baseline_estimator("constant", set), set, {}, 1, 1).metrics.normalised);
  set.states[0].unit = "m";
  set.states[1].unit = "m/s";
  const Evaluation constant = evaluate("constant", baseline_estimator("constant", set), set, {}, 1, 1);
  EXPECT_TRUE(constant.metrics.normalised);
  // The error of a constant is one standard deviation, except for rounding.
  EXPECT_NEAR(constant.metrics.nrmse.value(), 1.0, 1e-12);
  EXPECT_NE(evaluation_text(row_of("m", {constant})).find("normalised norm"), std::string::npos);
}

TEST(Evaluate, RefusesATestSetOfAnotherPlant) {
  Dataset set = test::van_der_pol_set(1, 1.0, 3);
  set.states.push_back({"x3", "", 0.0});
  EXPECT_THROW(evaluate_on_plant(low_pass_model(), set, {}, 1, 1), codegen::Error);
  set.trajectories.clear();
  EXPECT_THROW(evaluate("echo", echo_first_output, set, {}, 1, 1), codegen::Error);
}

TEST(EvaluationJson, HasTheDocumentedKeysAndOnlyFiniteNumbers) {
  // In 3 s there is neither a settled error nor a settling time.
  const Dataset set = test::van_der_pol_set(2, 3.0, 3);
  const Evaluation own = evaluate_on_plant(low_pass_model(), set, kUniform, 9, 1);
  const Evaluation constant = evaluate("constant", baseline_estimator("constant", set), set, kUniform, 9, 1);
  const auto json = nlohmann::json::parse(evaluation_json(row_of("low_pass", {own, constant}), 2.0));
  EXPECT_EQ(json.at("noise"), "uniform:3");
  EXPECT_EQ(json.at("seed"), 9);
  EXPECT_EQ(json.at("norm"), own.metrics.norm);
  EXPECT_EQ(json.at("nrmse"), *own.metrics.nrmse);
  EXPECT_TRUE(json.at("settled").is_null());
  EXPECT_TRUE(json.at("settling_time_s").is_null());
  EXPECT_EQ(json.at("per_component").size(), 2U);
  EXPECT_EQ(json.at("trajectories"), 2);
  EXPECT_EQ(json.at("box_scale"), 2.0);
  EXPECT_TRUE(json.at("excitation").empty());
  EXPECT_EQ(json.at("against").at("constant").at("norm"), constant.metrics.norm);
}

TEST(EvaluationJson, NamesTheExcitation) {
  const Dataset set = test::van_der_pol_set(1, 1.0, 3);
  Evaluation own = evaluate_on_plant(low_pass_model(), set, {}, 9, 1);
  own.excitation = {{"u", "cos(12*t)"}};
  EXPECT_EQ(nlohmann::json::parse(evaluation_json(row_of("m", {own}), 1.0)).at("excitation").at("u"), "cos(12*t)");
  EXPECT_NE(evaluation_text(row_of("m", {own})).find("seed 9, u = cos(12*t)"), std::string::npos);
}

TEST(EvaluationText, NamesTheTestAndOneRowPerEstimator) {
  const Dataset set = test::van_der_pol_set(2, 3.0, 3);
  const Evaluation own = evaluate_on_plant(low_pass_model(), set, kGaussian, 9, 1);
  const std::string text = evaluation_text(row_of("low_pass", {own}));
  EXPECT_NE(text.find("low_pass on 2 trajectories of 3 s, noise gaussian:0.5, seed 9"), std::string::npos) << text;
  EXPECT_NE(text.find("observer"), std::string::npos) << text;
  EXPECT_EQ(text.find("nan"), std::string::npos) << text;
}

/// Two runs of four samples: the state is constant at 1 and at -2.
Dataset resting() {
  Dataset set;
  set.states = {{"angle", "rad", 0.0}};
  for (const double at : {1.0, -2.0}) {
    Trajectory& run = set.trajectories.emplace_back();
    run.time_s = Eigen::VectorXd::LinSpaced(4, 0.0, 3.0);
    run.states = Eigen::MatrixXd::Constant(1, 4, at);
  }
  return set;
}

TEST(ClosedLoopCost, IsTheDistanceFromTheRunThatFeedsBackTheTrueState) {
  Dataset flown = resting();
  EXPECT_EQ(closed_loop_cost(resting(), flown).deviation(0), 0.0);
  flown.trajectories[0].states.array() += 2.0;  // up to 3, within twice the range, which is 2
  const ClosedLoopCost cost = closed_loop_cost(resting(), flown);
  EXPECT_NEAR(cost.deviation(0), std::sqrt(2.0), 1e-15);  // 4 over half of the samples
  EXPECT_EQ(cost.runs, 2);
  EXPECT_EQ(cost.left, 0);
}

TEST(ClosedLoopCost, CountsRunsThatLeaveTheRange) {
  Dataset flown = resting();
  flown.trajectories[1].states(0, 3) = -4.1;
  const ClosedLoopCost cost = closed_loop_cost(resting(), flown);
  EXPECT_EQ(cost.left, 1);
  EXPECT_THAT(to_text(cost, flown.states), testing::HasSubstr("1 of 2 runs exceed 2 times the range of that loop"));
}

TEST(ClosedLoopCost, RefusesSetsOfDifferentRuns) {
  Dataset flown = resting();
  flown.trajectories.pop_back();
  EXPECT_THROW(closed_loop_cost(resting(), flown), codegen::Error);
}

}  // namespace
}  // namespace nlo::trainer
