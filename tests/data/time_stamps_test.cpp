// SPDX-License-Identifier: MIT
#include "trainer/data/time_stamps.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

constexpr double kRounding = 1e-12;

TEST(TimeStamps, ReportsMedianTailsAndGaps) {
  Eigen::VectorXd time(201);
  time[0] = 0.0;
  for (int k = 1; k <= 200; ++k)
    time[k] = time[k - 1] + (k == 50 ? 0.008 : k == 70 ? 0.005 : k % 40 == 0 ? 0.003 : 0.004);
  const TimeStampReport report = report_time_stamps("run.csv", time, 0.004);
  EXPECT_EQ(report.samples, 201);
  EXPECT_NEAR(report.duration_s, time[200], kRounding);
  EXPECT_NEAR(report.median_s, 0.004, kRounding);
  EXPECT_NEAR(report.p01_s, 0.003, kRounding);
  EXPECT_NEAR(report.p99_s, 0.004, kRounding);
  EXPECT_NEAR(report.max_s, 0.008, kRounding);
  EXPECT_EQ(report.gaps, 1);
}

TEST(TimeStamps, MedianIsOverAllLogsTogether) {
  const Eigen::VectorXd slow = Eigen::VectorXd::LinSpaced(4, 0.0, 3.0), fast = Eigen::VectorXd::LinSpaced(11, 0.0, 1.0);
  EXPECT_NEAR(median_step({slow, fast}), 0.1, kRounding);
}

}  // namespace
}  // namespace nlo::trainer
