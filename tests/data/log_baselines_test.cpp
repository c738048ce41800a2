// SPDX-License-Identifier: MIT
#include "trainer/data/log_baselines.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "codegen/base/error.h"
#include "tests/data/data_testing.h"
#include "trainer/data/log_metrics.h"
#include "trainer/data/static_ridge.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr double kFitRounding = 1e-8;  // normal equations of degree 3 over 5 to 20 samples

VectorXd jittering_time(Index samples) {
  VectorXd time(samples);
  for (Index k = 0; k < samples; ++k)
    time[k] = 0.01 * (static_cast<double>(k) + 0.2 * std::sin(2.1 * static_cast<double>(k)));
  return time;
}

/// A measured position (a noisy sine) and two states: its velocity, and a hidden state.
Dataset swinging(double noise, unsigned seed) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal;
  Dataset data;
  data.outputs = {{"y", "rad", kTurn}};
  data.states = {{"v", "rad/s", 0.0}, {"hidden", "", 0.0}};
  Trajectory run;
  run.time_s = jittering_time(800);
  run.outputs = run.time_s.transpose().unaryExpr([&](double t) { return std::sin(3.0 * t) + noise * normal(engine); });
  run.states.resize(2, 800);
  run.states.row(0) = 3.0 * (3.0 * run.time_s.transpose()).array().cos();
  run.states.row(1).setConstant(7.0);
  run.weight = VectorXd::Ones(800);
  run.weight.head(20).setZero();
  data.trajectories = {run};
  return data;
}

const std::vector<StateSource> kSources = {{StateKind::kDerivativeOfMeasured, 0, -1, kTurn}, {}};

double rmse_of(const LogBaseline& baseline, const Dataset& data) {
  return log_metrics(data, {baseline.estimate(data.trajectories[0])}).pooled[0].rmse[0];
}

TEST(EndPointPolynomial, IsExactOnPolynomialsOfItsDegree) {
  const VectorXd t = jittering_time(60);
  const VectorXd y = 5.0 - 3.0 * t.array() + 20.0 * t.array().square() - 50.0 * t.array().cube();
  const VectorXd slope = -3.0 + 40.0 * t.array() - 150.0 * t.array().square();
  for (const int samples : {4, 5, 20}) {
    EXPECT_LT((end_point_estimate({samples, 3}, 1, t, y) - slope).tail(56).cwiseAbs().maxCoeff(), 1e3 * kFitRounding);
    EXPECT_LT((end_point_estimate({samples, 3}, 0, t, y) - y).cwiseAbs().maxCoeff(), kFitRounding);
  }
  EXPECT_GT((end_point_estimate({20, 1}, 1, t, y) - slope).tail(40).cwiseAbs().maxCoeff(), 0.1);  // control
}

TEST(EndPointPolynomial, WithTwoSamplesIsTheBackwardDifference) {
  const VectorXd t = jittering_time(50), y = (10.0 * t).array().sin();
  const VectorXd slope = end_point_estimate({2, 1}, 1, t, y);
  EXPECT_EQ(slope[0], 0.0);
  for (Index k = 1; k < 50; ++k) EXPECT_NEAR(slope[k], (y[k] - y[k - 1]) / (t[k] - t[k - 1]), kFitRounding);
}

TEST(EndPointPolynomial, UsesNoFutureSamples) {
  const VectorXd t = jittering_time(50), y = (10.0 * t).array().sin();
  VectorXd other = y;
  other.tail(20).setConstant(1e6);
  for (const int derivative : {0, 1})
    EXPECT_EQ(VectorXd(end_point_estimate({8, 2}, derivative, t, y).head(30)),
              VectorXd(end_point_estimate({8, 2}, derivative, t, other).head(30)));
}

TEST(LogBaseline, ConstantIsTheMeanOfTheUnmaskedTruth) {
  Dataset data = swinging(0.0, 1);
  data.trajectories[0].states(1, 0) = 1e9;  // masked
  const Eigen::MatrixXd estimate = LogBaseline::fit("constant", data, kSources).estimate(data.trajectories[0]);
  EXPECT_NEAR(estimate(1, 0), 7.0, kFitRounding);
  EXPECT_EQ(estimate(1, 0), estimate(1, 799));
}

TEST(LogBaseline, ConstantOfAnAngleIsItsMeanDirection) {
  Dataset data = swinging(0.0, 1);
  data.states[1].wrap = 360.0;
  for (Index k = 0; k < 800; ++k) data.trajectories[0].states(1, k) = k % 2 == 0 ? 179.0 : -179.0;
  const double mean = LogBaseline::fit("constant", data, kSources).estimate(data.trajectories[0])(1, 0);
  EXPECT_NEAR(std::abs(mean), 180.0, kFitRounding);
}

TEST(LogBaseline, DifferencesAndPolynomialsDoNotApplyToAHiddenState) {
  const Dataset data = swinging(0.01, 1);
  for (const std::string& name : LogBaseline::names()) {
    const LogBaseline baseline = LogBaseline::fit(name, data, kSources);
    const bool anywhere = name == "constant" || name == "static_ridge";
    EXPECT_EQ(baseline.applies(0), name != "sensor") << name << ": y is in rad, the state in rad/s";
    EXPECT_EQ(baseline.applies(1), anywhere) << name;
    EXPECT_EQ(std::isnan(baseline.estimate(data.trajectories[0])(1, 5)), !anywhere) << name;
  }
}

TEST(LogBaseline, SensorIsTheNearestOutputInTheUnitOfAState) {
  Dataset data = swinging(0.0, 1);
  data.outputs = {{"wheel", "rad/s", 0.0}, {"coarse", "rad/s", 0.0}, {"y", "rad", 0.0}};
  Trajectory& run = data.trajectories[0];
  run.outputs.resize(3, 800);
  run.outputs.row(0) = run.states.row(0).array() + 0.1;
  run.outputs.row(1) = run.states.row(0).array() + 0.5;
  run.outputs.row(2) = run.states.row(0);  // more accurate, but an angle
  const LogBaseline sensor = LogBaseline::fit("sensor", data, kSources);
  EXPECT_EQ(sensor.describe(0), "output wheel as it is");
  EXPECT_EQ(sensor.estimate(run)(0, 100), run.outputs(0, 100));
  EXPECT_FALSE(sensor.applies(1));
  run.outputs.row(0) = run.states.row(0);
  EXPECT_FALSE(LogBaseline::fit("sensor", data, kSources).applies(0)) << "an output equal to the truth is not a sensor";
  run.outputs.topRows(2).setConstant(100.0);
  EXPECT_FALSE(LogBaseline::fit("sensor", data, kSources).applies(0)) << "the mean is more accurate";
}

TEST(LogBaseline, PolynomialChoosesLongerWindowsForNoisierLogs) {
  const unsigned seed = 7;
  double difference_before = 0.0;
  for (const double noise : {0.0, 0.002, 0.02}) {
    const Dataset train = swinging(noise, seed), test = swinging(noise, seed + 1);
    const double difference = rmse_of(LogBaseline::fit("difference", train, kSources), test);
    const LogBaseline polynomial = LogBaseline::fit("polynomial", train, kSources);
    EXPECT_LT(rmse_of(polynomial, test), 0.5 * difference) << polynomial.describe(0) << ", seed " << seed;
    EXPECT_GT(difference, difference_before);
    difference_before = difference;
  }
  EXPECT_THAT(LogBaseline::fit("polynomial", swinging(0.02, seed), kSources).describe(0), HasSubstr("samples"));
}

TEST(LogBaseline, HandlesWrapsAndSinesAndCosines) {
  Dataset data = swinging(0.0, 1);
  data.trajectories[0].outputs *= 4.0;  // more than half a turn
  data.trajectories[0].states.row(0) *= 4.0;
  const double reference = rmse_of(LogBaseline::fit("difference", data, kSources), data);
  EXPECT_LT(reference, 0.5);

  Dataset wrapped = data;
  for (double& y : wrapped.trajectories[0].outputs.reshaped()) y = std::remainder(y, kTurn);
  EXPECT_NEAR(rmse_of(LogBaseline::fit("difference", wrapped, kSources), wrapped), reference, kFitRounding);

  Dataset encoded = data;
  encoded.outputs = {{"y_sin", "", 0.0}, {"y_cos", "", 0.0}};
  const Eigen::RowVectorXd angle = data.trajectories[0].outputs.row(0);
  encoded.trajectories[0].outputs.resize(2, angle.size());
  encoded.trajectories[0].outputs << angle.array().sin(), angle.array().cos();
  const std::vector<StateSource> sources = {{StateKind::kDerivativeOfMeasured, 0, 1, kTurn}, {}};
  EXPECT_NEAR(rmse_of(LogBaseline::fit("difference", encoded, sources), encoded), reference, kFitRounding);
}

TEST(LogBaseline, RefusesUnknownNames) {
  EXPECT_THAT(thrown_message([] { LogBaseline::fit("kalman", swinging(0.0, 1), kSources); }),
              HasSubstr("no baseline \"kalman\": expected one of constant, sensor, difference, polynomial"));
}

/// x1 = 2 y_k u_k - y_(k-2) + 3; x2 is the angle y turned by 100 degrees.
Dataset logs_of_a_product() {
  constexpr Index kSamples = 400;
  Dataset logs{
      {{"y", "", 0.0}, {"angle", "deg", 360.0}}, {{"x1", "", 0.0}, {"x2", "deg", 360.0}}, 0.1, true, {Trajectory()}};
  logs.inputs = {{"u", "", 0.0}};
  Trajectory& run = logs.trajectories[0];
  run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.1 * (kSamples - 1));
  run.weight = Eigen::VectorXd::Ones(kSamples);
  run.outputs.resize(2, kSamples);
  run.states.resize(2, kSamples);
  run.inputs.resize(1, kSamples);
  for (Index k = 0; k < kSamples; ++k) {
    const auto t = static_cast<double>(k);
    run.outputs(0, k) = std::sin(0.7 * t) + 0.3 * std::cos(2.1 * t);
    run.outputs(1, k) = 37.0 * t;
    run.inputs(0, k) = std::cos(1.3 * t);
    run.states(0, k) = 2.0 * run.outputs(0, k) * run.inputs(0, k) - run.outputs(0, std::max<Index>(0, k - 2)) + 3.0;
    run.states(1, k) = std::remainder(run.outputs(1, k) + 100.0, 360.0);
  }
  run.weight[5] = 0.0;
  run.states(0, 5) = std::numeric_limits<double>::quiet_NaN();
  return logs;
}

TEST(StaticRidge, EstimatesAProductAndAnAngleFromTheLastThreeSamples) {
  const Dataset logs = logs_of_a_product();
  const Trajectory& run = logs.trajectories[0];
  const Eigen::MatrixXd x = StaticRidge::fit(logs).estimate(run);
  const auto worst = [&](const Eigen::MatrixXd& estimate) {
    double largest = 0.0;
    for (Index k = 6; k < run.samples(); ++k) largest = std::max(largest, std::abs(estimate(0, k) - run.states(0, k)));
    return largest;
  };
  EXPECT_LT(worst(x), 1e-3);  // the bias of the ridge
  EXPECT_GT(worst(StaticRidge::fit(logs, 2).estimate(run)), 0.05) << "control: two samples are not enough";
  for (Index k = 6; k < run.samples(); ++k)
    ASSERT_LT(std::abs(std::remainder(x(1, k) - run.states(1, k), 360.0)), 0.1) << k;
}

TEST(StaticRidge, NeedsTruth) {
  Dataset logs = logs_of_a_product();
  logs.trajectories[0].weight.setZero();
  EXPECT_THAT([&] { StaticRidge::fit(logs); },
              testing::ThrowsMessage<codegen::Error>(testing::HasSubstr("no sample to fit it on")));
}

}  // namespace
}  // namespace nlo::trainer
