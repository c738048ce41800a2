// SPDX-License-Identifier: MIT
#include "trainer/data/scaling.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nlo::trainer {
namespace {

constexpr double kScalingRounding = 1e-12;

Trajectory run_of(const Eigen::RowVectorXd& output, const Eigen::RowVectorXd& state, const Eigen::VectorXd& weight) {
  Trajectory run;
  run.time_s = Eigen::VectorXd::LinSpaced(output.size(), 0.0, 1.0);
  run.outputs = output;
  run.states = state;
  run.weight = weight;
  return run;
}

Dataset two_runs() {
  Dataset data;
  data.outputs = {{"y", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.trajectories = {run_of(Eigen::RowVector3d(1, 2, 3), Eigen::RowVector3d(4, 100, 6), Eigen::Vector3d(1, 0, 1)),
                       run_of(Eigen::RowVector2d(4, 5), Eigen::RowVector2d(8, 10), Eigen::Vector2d(1, 1))};
  return data;
}

TEST(Scaling, OfOutputsCountsEverySample) {
  const Scaling scaling = output_scaling(two_runs());
  EXPECT_NEAR(scaling.mean[0], 3.0, kScalingRounding);
  EXPECT_NEAR(scaling.deviation[0], std::sqrt(2.0), kScalingRounding);
}

TEST(Scaling, OfStatesLeavesOutWhatIsMasked) {
  const Scaling scaling = state_scaling(two_runs());
  EXPECT_NEAR(scaling.mean[0], 7.0, kScalingRounding);
  EXPECT_NEAR(scaling.deviation[0], std::sqrt(5.0), kScalingRounding);
}

TEST(Scaling, GivesOneToAChannelThatNeverMoves) {
  Dataset data = two_runs();
  data.trajectories.resize(1);
  for (const double constant : {0.0, 0.1, 1e6}) {
    data.trajectories[0].outputs.setConstant(constant);
    EXPECT_EQ(output_scaling(data).deviation[0], 1.0) << constant;
  }
}

TEST(Scaling, KeepsItsDigitsBesideALargeOffset) {
  Dataset data = two_runs();
  for (Trajectory& run : data.trajectories) run.outputs.array() += 1e9;
  EXPECT_NEAR(output_scaling(data).deviation[0], std::sqrt(2.0), 1e-6);
}

}  // namespace
}  // namespace nlo::trainer
