// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "codegen/base/error.h"
#include "tests/support/thrown_message.h"

namespace nlo::trainer {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kRounding = 1e-12;  // sums of a few thousand terms of order 1, in double

const std::vector<Channel> kTwoStates = {{"x1", "", 0.0}, {"x2", "", 0.0}};

/// A run over [0, horizon] s whose true state is the constant `value`.
Trajectory constant_run(const Eigen::VectorXd& value, double horizon_s, double step_s) {
  const auto n = static_cast<Eigen::Index>(std::lround(horizon_s / step_s)) + 1;
  Trajectory run{"constant", Eigen::VectorXd(n), Eigen::MatrixXd::Zero(1, n), value.replicate(1, n),
                 Eigen::VectorXd::Ones(n)};
  for (Eigen::Index k = 0; k < n; ++k) run.time_s[k] = step_s * static_cast<double>(k);
  return run;
}

/// Settled from 10 s on, as in the paper's protocol.
MetricsConfig protocol() {
  MetricsConfig config;
  config.windows.push_back({"settled", 10.0, std::numeric_limits<double>::infinity()});
  return config;
}

ErrorMetrics metrics_of(const std::vector<Channel>& states, const Trajectory& run, const Eigen::MatrixXd& estimate,
                        double step_s) {
  ErrorAccumulator sum(states, step_s, protocol());
  sum.add(run, estimate);
  return sum.metrics();
}

TEST(Metrics, NormOfAConstantErrorIsThatError) {
  const Trajectory run = constant_run(Eigen::Vector2d(3.0, 4.0), 20.0, 0.1);
  Eigen::MatrixXd estimate = run.states;
  estimate.colwise() += Eigen::Vector2d(0.3, -0.4);
  const ErrorMetrics m = metrics_of(kTwoStates, run, estimate, 0.1);
  EXPECT_NEAR(m.norm, 0.5, kRounding);
  EXPECT_NEAR(m.per_component[0], 0.3, kRounding);
  EXPECT_NEAR(m.per_component[1], 0.4, kRounding);
  EXPECT_NEAR(m.nrmse.value(), 0.1, kRounding);  // |x| = 5
  EXPECT_NEAR(m.settled.value(), 0.5, kRounding);
  EXPECT_EQ(m.settling_time_s.value(), 0.0);
  EXPECT_EQ(m.samples, 201);
}

TEST(Metrics, NormOfAnExponentialErrorEqualsItsClosedForm) {
  // e(t_k) = a exp(-t_k): the mean of its square over N samples is a geometric series.
  constexpr double kStep = 0.01, kHorizon = 20.0, kAmplitude = 2.0;
  const Trajectory run = constant_run(Eigen::Vector2d::Zero(), kHorizon, kStep);
  Eigen::MatrixXd estimate = run.states;
  estimate.row(0) = kAmplitude * (-run.time_s.transpose().array()).exp();
  const ErrorMetrics m = metrics_of(kTwoStates, run, estimate, kStep);
  const auto n = static_cast<double>(run.samples());
  const double ratio = std::exp(-2.0 * kStep);
  const double mean_square = kAmplitude * kAmplitude * (1.0 - std::pow(ratio, n)) / (1.0 - ratio) / n;
  EXPECT_NEAR(m.norm, std::sqrt(mean_square), kRounding);
  EXPECT_EQ(m.per_component[1], 0.0);
  EXPECT_FALSE(m.nrmse.has_value());  // the truth is zero
  EXPECT_NEAR(m.curve[100], kAmplitude * std::exp(-1.0), kRounding);
  EXPECT_NEAR(m.curve_time_s[100], 1.0, kRounding);
}

TEST(Metrics, SettlingTimeIsTheTimeOfTheLastStepOfTheError) {
  // The error is 1 until 3 s and 0.1 after that. Windows that start at 3 s or later contain only 0.1; one sample of the
  // large error in a window of 10 samples would give sqrt((1 + 9 * 0.01) / 10) = 0.33 > 0.15.
  const Trajectory run = constant_run(Eigen::Vector2d::Zero(), 20.0, 0.1);
  Eigen::MatrixXd estimate = run.states;
  for (Eigen::Index k = 0; k < run.samples(); ++k) estimate(0, k) = k < 30 ? 1.0 : 0.1;
  const ErrorMetrics m = metrics_of(kTwoStates, run, estimate, 0.1);
  EXPECT_NEAR(m.settled.value(), 0.1, kRounding);
  EXPECT_NEAR(m.settling_time_s.value(), 3.0, kRounding);
}

TEST(Metrics, ErrorThatGrowsAtTheEndNeverSettles) {
  const Trajectory run = constant_run(Eigen::Vector2d::Zero(), 20.0, 0.1);
  Eigen::MatrixXd estimate = run.states;
  for (Eigen::Index k = 0; k < run.samples(); ++k) estimate(0, k) = k < 190 ? 0.1 : 1.0;
  EXPECT_FALSE(metrics_of(kTwoStates, run, estimate, 0.1).settling_time_s.has_value());
}

TEST(Metrics, RunShorterThanTenSecondsHasNoSettledError) {
  const Trajectory run = constant_run(Eigen::Vector2d::Ones(), 9.9, 0.1);
  const ErrorMetrics m = metrics_of(kTwoStates, run, 2.0 * run.states, 0.1);
  EXPECT_FALSE(m.settled.has_value());
  EXPECT_FALSE(m.settling_time_s.has_value());
  EXPECT_EQ(m.settled_per_component.size(), 0);
}

TEST(Metrics, SettledErrorIncludesTheSampleAtTenSeconds) {
  Trajectory run = constant_run(Eigen::Vector2d::Zero(), 10.0, 0.02);
  for (Eigen::Index k = 1; k < run.samples(); ++k) run.time_s[k] = run.time_s[k - 1] + 0.02;  // ends at 9.99999... s
  Eigen::MatrixXd estimate = run.states;
  estimate(0, run.samples() - 1) = 7.0;
  EXPECT_NEAR(metrics_of(kTwoStates, run, estimate, 0.02).settled.value(), 7.0, kRounding);
}

TEST(Metrics, AnglesAreComparedTheShortWayRound) {
  const std::vector<Channel> angle = {{"alpha", "rad", 2.0 * kPi}};
  const Trajectory run = constant_run(Eigen::VectorXd::Constant(1, kPi - 0.01), 1.0, 0.1);
  Eigen::MatrixXd estimate = Eigen::MatrixXd::Constant(1, run.samples(), -kPi + 0.01 + 6.0 * kPi);
  EXPECT_NEAR(metrics_of(angle, run, estimate, 0.1).norm, 0.02, kRounding);
  // Control: without the wrap the same estimate is wrong by three turns.
  EXPECT_NEAR(metrics_of({{"alpha", "rad", 0.0}}, run, estimate, 0.1).norm, 4.0 * kPi + 0.02, kRounding);
}

TEST(Metrics, MaskedSamplesDoNotCount) {
  Trajectory run = constant_run(Eigen::Vector2d::Ones(), 1.0, 0.1);
  Eigen::MatrixXd estimate = run.states;
  estimate(0, 3) = 1e6;
  run.weight[3] = 0.0;
  const ErrorMetrics m = metrics_of(kTwoStates, run, estimate, 0.1);
  EXPECT_EQ(m.norm, 0.0);
  EXPECT_EQ(m.samples, 10);
  EXPECT_EQ(m.curve.size(), 10);
}

TEST(Metrics, ErrorsNameANonFiniteEstimate) {
  const Trajectory run = constant_run(Eigen::Vector2d::Ones(), 1.0, 0.1);
  Eigen::MatrixXd estimate = run.states;
  estimate(1, 4) = std::numeric_limits<double>::quiet_NaN();
  const std::string message = thrown_message([&] { metrics_of(kTwoStates, run, estimate, 0.1); });
  EXPECT_THAT(message, testing::HasSubstr("x2"));
  EXPECT_THAT(message, testing::HasSubstr("sample 4"));
}

TEST(Metrics, EmptyTestIsAnError) {
  EXPECT_THROW(ErrorAccumulator(kTwoStates, 0.1).metrics(), codegen::Error);
  EXPECT_THROW(ErrorAccumulator(kTwoStates, 0.0), codegen::Error);
}

TEST(Metrics, JoinedPartsEqualTheWhole) {
  const Trajectory run = constant_run(Eigen::Vector2d(1.0, 2.0), 12.0, 0.1);
  ErrorAccumulator whole(kTwoStates, 0.1, protocol()), first = whole, second = whole;
  for (int i = 0; i < 6; ++i) {
    const Eigen::MatrixXd estimate = run.states * (1.0 + 0.1 * i);
    whole.add(run, estimate);
    (i < 3 ? first : second).add(run, estimate);
  }
  first.merge(second);
  EXPECT_NEAR(first.metrics().norm, whole.metrics().norm, kRounding);
  EXPECT_NEAR(*first.metrics().settled, *whole.metrics().settled, kRounding);
  EXPECT_LT((first.metrics().curve - whole.metrics().curve).norm(), kRounding);
}

TEST(Metrics, WindowsSeparateTheirSamples) {
  MetricsConfig config = protocol();
  config.windows.push_back({"early", 0.5, 5.0});
  config.windows.push_back({"never", 30.0, 40.0});
  const Trajectory run = constant_run(Eigen::Vector2d::Zero(), 20.0, 0.1);
  Eigen::MatrixXd estimate = run.states;
  estimate.row(0).segment(5, 45).setConstant(2.0);  // 0.5 s <= t < 5 s
  ErrorAccumulator sum(kTwoStates, 0.1, config);
  sum.add(run, estimate);
  const ErrorMetrics m = sum.metrics();
  ASSERT_EQ(m.windows.size(), 4U);
  EXPECT_NEAR(m.windows[0].norm.value(), std::sqrt(45.0 * 4.0 / 201.0), kRounding);
  EXPECT_EQ(m.windows[1].norm.value(), 0.0);
  EXPECT_NEAR(m.windows[2].norm.value(), 2.0, kRounding);
  EXPECT_NEAR(m.windows[2].per_component[0], 2.0, kRounding);
  EXPECT_FALSE(m.windows[3].norm.has_value());
}

/// x1 moves by 0.5 m, x2 by 2000 degrees; each estimate is wrong by a tenth of its state.
ErrorMetrics of_mixed_units(double degrees_per_unit) {
  const std::vector<Channel> states = {{"x1", "m", 0.0}, {"x2", degrees_per_unit == 1.0 ? "deg" : "turn", 0.0}};
  Trajectory run = constant_run(Eigen::Vector2d::Zero(), 20.0, 0.1);
  run.states.row(0) = 0.5 * run.time_s.transpose().array().sin();
  run.states.row(1) = 2000.0 / degrees_per_unit * run.time_s.transpose().array().cos();
  Dataset set{{}, states, 0.1, true, {run}};
  MetricsConfig config;
  config.state_scale = state_deviation(set);
  ErrorAccumulator sum(states, 0.1, config);
  sum.add(run, 1.1 * run.states);
  return sum.metrics();
}

TEST(Metrics, NormOfStatesOverTheirDeviationDoesNotDependOnUnits) {
  const ErrorMetrics degrees = of_mixed_units(1.0), turns = of_mixed_units(360.0);
  EXPECT_TRUE(degrees.normalised);
  EXPECT_NEAR(degrees.norm, turns.norm, kRounding);
  EXPECT_NEAR(degrees.per_component[1], 360.0 * turns.per_component[1], 1e-9);  // control: RMSE keep their units
  // The error is a tenth of each state. The mean of a state over 20 s is not zero, so its deviation is slightly below
  // its RMS.
  EXPECT_NEAR(degrees.nrmse.value(), 0.1, 0.005);
}

TEST(Metrics, DeviationOfAnAngleIsAboutItsMeanDirection) {
  Trajectory run = constant_run(Eigen::VectorXd::Zero(1), 20.0, 0.1);
  run.states.row(0) = kPi + 0.1 * run.time_s.transpose().array().sin();  // swings about the wrap
  run.weight[0] = 0.0;
  run.states(0, 0) = std::numeric_limits<double>::quiet_NaN();
  const double deviation = state_deviation({{}, {{"alpha", "rad", 2.0 * kPi}}, 0.1, true, {run}})[0];
  EXPECT_NEAR(deviation, 0.1 / std::sqrt(2.0), 0.005);  // 20 s contain 3.2 periods, not a whole number
  EXPECT_TRUE(share_a_unit({{"a", "m", 0.0}, {"b", "m", 0.0}}));
  EXPECT_FALSE(share_a_unit({{"a", "m", 0.0}, {"b", "", 0.0}}));
}

TEST(Metrics, WeighsRunsByTheirNumberOfSamples) {
  // 11 samples with error 1 and 31 samples with error 0: the mean is over samples, not over runs.
  const Trajectory brief = constant_run(Eigen::Vector2d::Zero(), 1.0, 0.1),
                   longer = constant_run(Eigen::Vector2d::Zero(), 3.0, 0.1);
  Eigen::MatrixXd off = brief.states;
  off.row(0).setOnes();
  ErrorAccumulator sum(kTwoStates, 0.1);
  sum.add(brief, off);
  sum.add(longer, longer.states);
  EXPECT_NEAR(sum.metrics().norm, std::sqrt(11.0 / 42.0), kRounding);
  EXPECT_NEAR(sum.metrics().curve[5], std::sqrt(0.5), kRounding);
  EXPECT_EQ(sum.metrics().curve[20], 0.0);
}

TEST(MetricsConfig, HasARateOfDecayIfTheStructureHasD) {
  Experiment experiment;
  experiment.observer.eigenvalues = {-100.0};
  EXPECT_EQ(metrics_config(experiment, 50.0).windows[2].from_s, 0.05);
  for (const char* structure : {"general", "luenberger"}) {
    experiment.observer.structure = structure;  // F of (11) starts from the eigenvalues and moves away from them
    EXPECT_EQ(metrics_config(experiment, 50.0).windows[2].from_s, 10.0) << structure;
  }
}

}  // namespace
}  // namespace nlo::trainer
