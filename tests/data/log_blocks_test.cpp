// SPDX-License-Identifier: MIT
#include "trainer/data/log_blocks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

Dataset run_of(Eigen::Index samples) {
  Dataset log;
  Trajectory& run = log.trajectories.emplace_back();
  run.time_s = Eigen::VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1));
  run.outputs = run.time_s.transpose();
  run.states = run.outputs;
  run.weight = Eigen::VectorXd::Ones(samples);
  return log;
}

TEST(LogBlocks, DivideARunIntoEqualParts) {
  Eigen::Vector4i samples = Eigen::Vector4i::Zero();
  for (Eigen::Index k = 0; k < 10; ++k) ++samples(block_of(k, 10, 4));
  EXPECT_EQ(samples, Eigen::Vector4i(3, 2, 3, 2));
  EXPECT_EQ(block_of(0, 1, 4), 0) << "a run shorter than the number of blocks";
}

TEST(LogBlocks, MaskTheTruthAndKeepTheReadings) {
  const Dataset log = run_of(6);
  const Trajectory inside = only_block(log, 1, 3).trajectories.front(),
                   outside = without_block(log, 1, 3).trajectories.front();
  EXPECT_THAT(inside.weight, ::testing::ElementsAre(0, 0, 1, 1, 0, 0));
  EXPECT_THAT(outside.weight, ::testing::ElementsAre(1, 1, 0, 0, 1, 1));
  EXPECT_EQ(inside.outputs, log.trajectories.front().outputs);
  EXPECT_EQ(outside.outputs, log.trajectories.front().outputs);
}

TEST(LogBlocks, KeepTruthMaskedThatTheLogMasks) {
  Dataset log = run_of(4);
  log.trajectories.front().weight(0) = 0.0;
  EXPECT_EQ(only_block(log, 0, 2).trajectories.front().weight, Eigen::Vector4d(0, 1, 0, 0));
}

}  // namespace
}  // namespace nlo::trainer
