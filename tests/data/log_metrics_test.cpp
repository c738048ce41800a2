// SPDX-License-Identifier: MIT
#include "trainer/data/log_metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/data/data_testing.h"
#include "trainer/data/evaluation_windows.h"
#include "trainer/data/transient.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using ::testing::HasSubstr;

constexpr double kMetricRounding = 1e-12;
constexpr double kEnd = std::numeric_limits<double>::infinity();
const EvaluationWindows kWindows = {{"all", 0.0, kEnd}, {"after_2_s", 2.0, kEnd}, {"early", 0.5, 5.0}};

/// Ten seconds at 10 Hz with all states zero and no mask.
Dataset at_rest(std::vector<Channel> states) {
  Dataset data;
  data.states = std::move(states);
  Trajectory run;
  run.source = "rest.csv";
  run.time_s = Eigen::VectorXd::LinSpaced(101, 0.0, 10.0);
  run.states = MatrixXd::Zero(static_cast<Eigen::Index>(data.states.size()), 101);
  run.weight = Eigen::VectorXd::Ones(101);
  data.trajectories = {run};
  return data;
}

TEST(LogMetrics, SeparatesItsWindows) {
  const Dataset data = at_rest({{"v", "rad/s", 0.0}});
  MatrixXd estimate = MatrixXd::Zero(1, 101);
  estimate.leftCols(5).setConstant(6.0);          // before 0.5 s
  estimate.block(0, 5, 1, 15).setConstant(2.0);   // 0.5 to 2 s
  estimate.block(0, 50, 1, 51).setConstant(1.0);  // from 5 s on
  const StateError error = log_metrics(data, {estimate}, {}, kWindows).pooled[0];
  EXPECT_EQ(error.unit, "rad/s");
  EXPECT_NEAR(error.rmse[0], std::sqrt((5 * 36.0 + 15 * 4.0 + 51 * 1.0) / 101.0), kMetricRounding);
  EXPECT_NEAR(error.rmse[1], std::sqrt(51.0 / 81.0), kMetricRounding);
  EXPECT_NEAR(error.rmse[2], std::sqrt(15 * 4.0 / 45.0), kMetricRounding);
}

TEST(LogMetrics, IgnoresMaskedSamples) {
  Dataset data = at_rest({{"v", "", 0.0}});
  MatrixXd estimate = MatrixXd::Constant(1, 101, 3.0);
  estimate(0, 40) = 1e6;
  EXPECT_GT(log_metrics(data, {estimate}).pooled[0].rmse[0], 1e4);  // control
  data.trajectories[0].weight[40] = 0.0;
  data.trajectories[0].states(0, 40) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NEAR(log_metrics(data, {estimate}).pooled[0].rmse[0], 3.0, kMetricRounding);
}

TEST(LogMetrics, ComparesAnglesTheShortWayRound) {
  const Dataset data = at_rest({{"phi", "deg", 360.0}, {"x", "m", 0.0}});
  const StateError phi = log_metrics(data, {MatrixXd::Constant(2, 101, 359.0)}).pooled[0];
  const StateError x = log_metrics(data, {MatrixXd::Constant(2, 101, 359.0)}).pooled[1];
  EXPECT_NEAR(phi.rmse[0], 1.0, kMetricRounding);
  EXPECT_NEAR(x.rmse[0], 359.0, kMetricRounding * 359.0);  // control: this state is not an angle
}

TEST(LogMetrics, ReadsAnAngleFromItsSineAndCosine) {
  Dataset data = at_rest({{"phi_sin", "", 0.0}, {"phi_cos", "", 0.0}});
  data.trajectories[0].states.row(0).setConstant(std::sin(3.1));
  data.trajectories[0].states.row(1).setConstant(std::cos(3.1));
  MatrixXd estimate(2, 101);
  estimate.row(0).setConstant(0.7 * std::sin(-3.1));  // not on the unit circle, and across the wrap
  estimate.row(1).setConstant(0.7 * std::cos(-3.1));
  const LogMetrics metrics = log_metrics(data, {estimate}, {{"phi", "rad", kTurn, 0}});
  ASSERT_EQ(metrics.pooled.size(), 3u);
  EXPECT_EQ(metrics.pooled[2].name, "phi");
  EXPECT_EQ(metrics.pooled[2].unit, "rad");
  EXPECT_NEAR(metrics.pooled[2].rmse[0], kTurn - 6.2, kMetricRounding);
}

TEST(LogMetrics, ComputesSmallAndLargeAnglesBetweenDirectionsToRounding) {
  Dataset data = at_rest({{"up_x", "", 0.0}, {"up_y", "", 0.0}, {"up_z", "", 0.0}});
  data.trajectories[0].states.row(2).setOnes();
  for (const double degrees : {1e-7, 0.5, 90.0, 179.9999}) {
    const double angle = degrees * kTurn / 360.0;
    MatrixXd estimate = MatrixXd::Zero(3, 101);
    estimate.row(1).setConstant(0.7 * std::sin(angle));  // its length has no effect
    estimate.row(2).setConstant(0.7 * std::cos(angle));
    const StateError error = log_metrics(data, {estimate}, {{"up", "deg", 0.0, 0, 3}}).pooled[3];
    EXPECT_NEAR(error.rmse[0], degrees, 1e-9 * degrees);
  }
}

TEST(LogMetrics, PoolsSamplesNotFiles) {
  Dataset data = at_rest({{"v", "", 0.0}});
  data.trajectories.push_back(data.trajectories[0]);
  data.trajectories[1].source = "half.csv";
  data.trajectories[1].weight.tail(51).setZero();
  const LogMetrics metrics = log_metrics(data, {MatrixXd::Constant(1, 101, 1.0), MatrixXd::Constant(1, 101, 2.0)});
  EXPECT_EQ(metrics.files[1].source, "half.csv");
  EXPECT_NEAR(metrics.files[0].states[0].rmse[0], 1.0, kMetricRounding);
  EXPECT_NEAR(metrics.files[1].states[0].rmse[0], 2.0, kMetricRounding);
  EXPECT_NEAR(metrics.pooled[0].rmse[0], std::sqrt((101 * 1.0 + 50 * 4.0) / 151.0), kMetricRounding);
}

TEST(LogMetrics, ALogOfManyRunsIsOneFile) {
  Dataset data = at_rest({{"v", "", 0.0}});
  data.trajectories.assign(4, data.trajectories[0]);
  for (std::size_t i = 0; i < 4; ++i) {
    data.trajectories[i].log = i < 3 ? "day1/log.csv" : "day2/log.csv";
    data.trajectories[i].source = i < 3 ? "log.csv (" + std::to_string(i + 1) + " of 3)" : "log.csv";
  }
  std::vector<MatrixXd> estimates;
  for (const double error : {1.0, 2.0, 3.0, 4.0}) estimates.push_back(MatrixXd::Constant(1, 101, error));
  const LogMetrics metrics = log_metrics(data, estimates);
  ASSERT_EQ(metrics.files.size(), 2u);
  EXPECT_EQ(metrics.runs, 4u);
  EXPECT_EQ(metrics.files[0].source, "log.csv (3 runs)");
  EXPECT_EQ(metrics.files[1].source, "log.csv");
  EXPECT_NEAR(metrics.files[0].states[0].rmse[0], std::sqrt((1.0 + 4.0 + 9.0) / 3.0), kMetricRounding);
  EXPECT_NEAR(metrics.files[1].states[0].rmse[0], 4.0, kMetricRounding);
}

TEST(LogMetrics, HasNoErrorWithoutScoredSamples) {
  Dataset data = at_rest({{"v", "", 0.0}});
  data.trajectories[0].time_s *= 0.1;  // one second, so no sample after 2 s
  const StateError error = log_metrics(data, {MatrixXd::Zero(1, 101)}, {}, kWindows).pooled[0];
  EXPECT_EQ(error.rmse[0], 0.0);
  EXPECT_TRUE(std::isnan(error.rmse[1]));
  EXPECT_TRUE(std::isnan(log_metrics(data, {MatrixXd::Constant(1, 101, std::nan(""))}).pooled[0].rmse[0]));
}

TEST(LogMetrics, RefusesEstimatesThatDoNotFit) {
  const Dataset data = at_rest({{"v", "", 0.0}});
  EXPECT_THAT(thrown_message([&] { log_metrics(data, {}); }), HasSubstr("estimates of 0 logs for 1 logs"));
  EXPECT_THAT(thrown_message([&] { log_metrics(data, {MatrixXd::Zero(1, 99)}); }),
              HasSubstr("rest.csv: an estimate of 1 x 99 for states of 1 x 101"));
}

struct Plant {
  std::string name;
  std::vector<double> eigenvalues;
  std::vector<std::array<double, 2>> pairs;
  double horizon_s, transient_s;
};

ObserverConfig observer_of(const Plant& plant) {
  ObserverConfig observer;
  observer.eigenvalues = plant.eigenvalues;
  observer.pairs = plant.pairs;
  return observer;
}

TEST(EvaluationWindows, FitTheSlowestTimeConstantAndTheHorizon) {
  const std::vector<Plant> plants = {
      {"a motor", {-200.0, -1000.0}, {}, 0.5, 0.025},
      {"an oscillator", {-1.0, -4.0}, {{-0.3, 0.9}}, 50.0, 16.0},
      {"an epidemic in days", {-0.25, -1.0}, {}, 120.0, 20.0},
      {"a battery", {-0.001, -0.1}, {}, 36000.0, 5000.0},
      {"one that never settles", {-0.01}, {}, 50.0, 25.0},  // 500 s would exceed the horizon
  };
  for (const Plant& plant : plants) {
    const EvaluationWindows windows = evaluation_windows({}, decay_rate(observer_of(plant)), plant.horizon_s);
    ASSERT_EQ(windows.size(), 3U) << plant.name;
    EXPECT_EQ(windows[0].name, "all");
    EXPECT_EQ(windows[1].to_s, plant.transient_s) << plant.name;
    EXPECT_EQ(windows[2].from_s, plant.transient_s) << plant.name;
    EXPECT_EQ(settled_window(windows), 2U);
    EXPECT_DOUBLE_EQ(settling_window_s({}, windows, plant.horizon_s), plant.transient_s / 10.0);
  }
}

TEST(EvaluationWindows, DependOnlyOnTheHorizonWithoutEigenvalues) {
  EXPECT_EQ(evaluation_windows({}, decay_rate({}), 50.0)[2].from_s, 10.0);
}

TEST(EvaluationWindows, ConfiguredWindowsReplaceDerivedOnes) {
  EvaluationConfig config;
  config.windows = {{"early", 0.5, 5.0}, {"late", 2.0, std::numeric_limits<double>::infinity()}};
  const EvaluationWindows windows = evaluation_windows(config, 0.0, 50.0);
  ASSERT_EQ(windows.size(), 3U);
  EXPECT_EQ(settled_window(windows), 2U) << "the first window that lasts to the end";
  EXPECT_EQ(window_text(windows[0]), "all");
  EXPECT_EQ(window_text(windows[1]), "early (0.5-5 s)");
  EXPECT_EQ(window_text(windows[2]), "late (t >= 2 s)");
  config.windows.pop_back();
  EXPECT_EQ(settled_window(evaluation_windows(config, 0.0, 50.0)), 0U) << "no window lasts to the end";
  config.settling_window_s = 0.3;
  EXPECT_EQ(settling_window_s(config, windows, 50.0), 0.3);
}

}  // namespace
}  // namespace nlo::trainer
