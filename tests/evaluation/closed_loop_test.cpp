// SPDX-License-Identifier: MIT
#include "trainer/evaluation/closed_loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

/// Two runs of four samples: one state rests at 1 and at -2.
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

TEST(ClosedLoopCost, IsTheDeviationFromTheLoopOfTheTrueState) {
  Dataset flown = resting();
  EXPECT_EQ(closed_loop_cost(resting(), flown).deviation(0), 0.0);
  flown.trajectories[0].states.array() += 2.0;  // up to 3, within twice the reach, 2
  const ClosedLoopCost cost = closed_loop_cost(resting(), flown);
  EXPECT_NEAR(cost.deviation(0), std::sqrt(2.0), 1e-15);  // 4 over half of the samples
  EXPECT_EQ(cost.runs, 2);
  EXPECT_EQ(cost.left, 0);
}

TEST(ClosedLoopCost, CountsRunsThatLeave) {
  Dataset flown = resting();
  flown.trajectories[1].states(0, 3) = -4.1;
  const ClosedLoopCost cost = closed_loop_cost(resting(), flown);
  EXPECT_EQ(cost.left, 1);
  EXPECT_THAT(to_text(cost, flown.states), testing::HasSubstr("1 of 2 runs go beyond 2 times its range"));
}

TEST(ClosedLoopCost, RefusesSetsOfDifferentRuns) {
  Dataset flown = resting();
  flown.trajectories.pop_back();
  EXPECT_THROW(closed_loop_cost(resting(), flown), codegen::Error);
}

}  // namespace
}  // namespace nlo::trainer
