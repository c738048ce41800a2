// SPDX-License-Identifier: MIT
#include "trainer/data/log_starts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

Dataset two_logs() {
  Dataset data;
  data.outputs = {{"y", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.inputs = {{"u", "", 0.0}};
  data.sample_period_s = 0.1;
  for (const int samples : {101, 31}) {
    Trajectory run;
    run.source = samples == 101 ? "long.csv" : "short.csv";
    run.time_s = Eigen::VectorXd::LinSpaced(samples, 0.0, 0.1 * (samples - 1)).array() + 7.0;
    run.outputs = run.time_s.transpose();
    run.states = 2.0 * run.time_s.transpose();
    run.inputs = 3.0 * run.time_s.transpose();
    run.weight = Eigen::VectorXd::LinSpaced(samples, 0.0, 1.0);
    run.first_estimate = 5;
    data.trajectories.push_back(run);
  }
  return data;
}

TEST(LogStarts, EachRunBeginsAtEachStartThatItReaches) {
  const Dataset logs = two_logs(), started = started_at(logs, {0.0, 0.3, 4.0});
  ASSERT_EQ(started.trajectories.size(), 5u) << "the short log ends after 3 s";
  EXPECT_EQ(started.trajectories[0].source, "long.csv");
  EXPECT_EQ(started.trajectories[0].samples(), 101);
  EXPECT_EQ(started.trajectories[0].first_estimate, 5);
  const Trajectory& run = started.trajectories[2];
  EXPECT_EQ(run.source.substr(0, 17), "long.csv from 0.3");
  ASSERT_EQ(run.samples(), 98);
  EXPECT_EQ(run.time_s(0), 0.0);
  EXPECT_NEAR(run.time_s(97), 9.7, 1e-12);
  EXPECT_EQ(run.outputs(0, 0), logs.trajectories[0].outputs(0, 3));
  EXPECT_EQ(run.states(0, 1), logs.trajectories[0].states(0, 4));
  EXPECT_EQ(run.inputs(0, 2), logs.trajectories[0].inputs(0, 5));
  EXPECT_EQ(run.weight(3), logs.trajectories[0].weight(6));
  EXPECT_EQ(run.first_estimate, 2);
  EXPECT_EQ(started.trajectories[4].samples(), 61);
}

TEST(LogStarts, AStartBeyondAllLogsIsRefused) {
  EXPECT_THROW(started_at(two_logs(), {-1.0}), codegen::Error);
  try {
    started_at(two_logs(), {0.0, 10.0});
    FAIL();
  } catch (const codegen::Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("--from 10: the longest log ends after 10 s"));
  }
}

}  // namespace
}  // namespace nlo::trainer
