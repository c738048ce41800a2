// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <vector>

#include "trainer/monitor/monitor_study.h"

namespace nlo::trainer {
namespace {

using codegen::WatchedRun;

/// One statistic of 100 samples at 10 Hz, armed after 10: above its limit at these samples.
WatchedRun run(const std::vector<int>& above) {
  WatchedRun made;
  made.levels = Eigen::MatrixXd::Constant(1, 100, 0.5);
  for (const int k : above) made.levels(0, k) = 2.0;
  made.armed_after = 10;
  return made;
}

TEST(AlarmCount, OneAlarmIsCountedUntilATimeConstantIsQuiet) {
  // Time constant 1 s: 10 samples. 20, 25 and 34 are one alarm, 60 another; 5 is before it is armed.
  const AlarmCount count = count_alarms({run({5, 20, 25, 34, 60}), run({})}, {Alarm::kInnovationMean}, 0.1, 1.0);
  EXPECT_DOUBLE_EQ(count.per_hour, 2.0 / (2 * 90 * 0.1 / 3600.0));
  EXPECT_DOUBLE_EQ(count.seen, 0.5);
  EXPECT_DOUBLE_EQ(count.median_delay_s.value(), 1.0);
  EXPECT_EQ(count.most, Alarm::kInnovationMean);
}

TEST(AlarmCount, SeenMeansWithinFiveTimeConstants) {
  EXPECT_DOUBLE_EQ(count_alarms({run({60})}, {Alarm::kMissing}, 0.1, 1.0).seen, 1.0);  // 5.0 s after being armed
  EXPECT_DOUBLE_EQ(count_alarms({run({61})}, {Alarm::kMissing}, 0.1, 1.0).seen, 0.0);
  EXPECT_FALSE(count_alarms({run({})}, {Alarm::kMissing}, 0.1, 1.0).median_delay_s);
}

}  // namespace
}  // namespace nlo::trainer
