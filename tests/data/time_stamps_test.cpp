// SPDX-License-Identifier: MIT
#include "trainer/data/time_stamps.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace nlo::trainer {
namespace {

constexpr double kTimeRounding = 1e-12;

TEST(TimeStamps, ReportsMedianTailsAndGaps) {
  Eigen::VectorXd time(201);
  time[0] = 0.0;
  for (int k = 1; k <= 200; ++k)
    time[k] = time[k - 1] + (k == 50 ? 0.008 : k == 70 ? 0.005 : k % 40 == 0 ? 0.003 : 0.004);
  const TimeStampReport report = report_time_stamps("run.csv", {time}, 0.004);
  EXPECT_EQ(report.samples, 201);
  EXPECT_NEAR(report.duration_s, time[200], kTimeRounding);
  EXPECT_NEAR(report.median_s, 0.004, kTimeRounding);
  EXPECT_NEAR(report.p01_s, 0.003, kTimeRounding);
  EXPECT_NEAR(report.p99_s, 0.004, kTimeRounding);
  EXPECT_NEAR(report.max_s, 0.008, kTimeRounding);
  EXPECT_EQ(report.gaps, 1);
}

/// t_k = 3.2 + k T + jitter, as printed with `digits` decimals.
Eigen::VectorXd stamps(int samples, double period_s, double jitter_s, int digits) {
  std::mt19937 engine(7);
  std::uniform_real_distribution<double> jitter(-jitter_s, jitter_s);
  Eigen::VectorXd time(samples);
  for (int k = 0; k < samples; ++k)
    time[k] = std::round((3.2 + k * period_s + jitter(engine)) * std::pow(10.0, digits)) / std::pow(10.0, digits);
  return time;
}

TimeGrid grid_of(const Eigen::VectorXd& time) {
  return fit_time_grid(time, stamp_resolution(time));
}

TEST(TimeStamps, RegularWithinTheirRounding) {
  // 7 and 8 ms printed for 7.5; 2 and 3 for 2.5, where the median step is 20 % off.
  for (const double period_s : {1.0 / 120.0, 0.0075, 0.0025, 1.0 / 300.0}) {
    const TimeGrid grid = grid_of(stamps(2000, period_s, 0.0, 3));
    EXPECT_TRUE(grid.regular && grid.rounded && grid.complete) << period_s;
    // 1 ms over 2000 samples: the worst that rounding can do to least squares is 1.5 times that.
    EXPECT_NEAR(grid.period_s, period_s, 1.5e-3 / 2000.0) << period_s;
  }
}

TEST(TimeStamps, NotRegularWhenTheyJitterBeyondTheirRounding) {
  EXPECT_FALSE(grid_of(stamps(2000, 0.008, 1.5e-3, 3)).regular);
  EXPECT_FALSE(grid_of(stamps(2000, 0.004, 0.8e-3, 9)).regular);  // a fifth of a period
}

TEST(TimeStamps, RegularWithASmallJitterAndThenAsStamped) {
  const TimeGrid grid = grid_of(stamps(2000, 0.004, 0.24e-3, 9));  // 6 %, as the Qube's
  EXPECT_TRUE(grid.regular);
  EXPECT_FALSE(grid.rounded);
}

TEST(TimeStamps, NotRegularWhenTheClockWanders) {
  Eigen::VectorXd time(2000);  // no step is wrong by more than 0.3 %, and half a period is lost in between
  for (int k = 0; k < 2000; ++k) time[k] = 0.01 * (k + 0.5 * std::sin(6e-3 * k));
  EXPECT_FALSE(grid_of(time).regular);
}

TEST(TimeStamps, GridLeavesOutMissingSamples) {
  const Eigen::VectorXd all = stamps(2000, 0.0075, 0.0, 3);
  Eigen::VectorXd some(1997);
  some << all.head(700), all.segment(702, 298), all.tail(999);  // two in a row, and one
  const TimeGrid grid = grid_of(some);
  EXPECT_TRUE(grid.regular && grid.rounded);
  EXPECT_FALSE(grid.complete);
  EXPECT_NEAR(grid.period_s, 0.0075, 1e-6);
  EXPECT_EQ(grid.counts[700], 702.0);
  EXPECT_EQ(grid.counts[1996], 1999.0);
}

TEST(TimeStamps, ResolutionIsThatOfThePrint) {
  EXPECT_DOUBLE_EQ(stamp_resolution(stamps(100, 1.0 / 120.0, 0.0, 3)), 1e-3);
  EXPECT_DOUBLE_EQ(stamp_resolution(stamps(100, 1.0 / 120.0, 0.0, 6)), 1e-6);
  EXPECT_DOUBLE_EQ(stamp_resolution(Eigen::Vector4d(0, 8, 17, 25)), 1.0);
  EXPECT_DOUBLE_EQ(stamp_resolution(stamps(100, 1.0 / 120.0, 0.0, 3).array() + 1.7e9), 1e-3);  // seconds since 1970
  EXPECT_EQ(stamp_resolution(Eigen::Vector3d(0.0, std::sqrt(2.0), 3.0)), 0.0);
}

TEST(TimeStamps, PeriodsAgreeToAThousandthAndWhatTheLengthCanTell) {
  const TimeGrid whole = grid_of(stamps(2000, 0.0075, 0.0, 3)), piece = grid_of(stamps(30, 0.0075, 0.0, 3));
  EXPECT_TRUE(has_period(whole, 0.0075));
  EXPECT_FALSE(has_period(whole, 0.0075 * 1.002));
  EXPECT_TRUE(has_period(piece, 0.0075 * 1.002));  // 30 samples of 1 ms
  EXPECT_FALSE(has_period(piece, 0.008));
}

TEST(TimeStamps, MedianIsOverAllLogsTogether) {
  const Eigen::VectorXd slow = Eigen::VectorXd::LinSpaced(4, 0.0, 3.0), fast = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0);
  EXPECT_NEAR(median_step({slow, fast}), 0.1, kTimeRounding);
}

}  // namespace
}  // namespace nlo::trainer
