// SPDX-License-Identifier: MIT
#include "trainer/data/angle.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/data/testing.h"

namespace nlo::trainer {
namespace {

using Eigen::VectorXd;

constexpr double kRounding = 1e-12;  // some units in the last place of angles up to a hundred turns

TEST(WrapDifference, LiesInTheHalfOpenTurn) {
  for (const double wrap : {kTurn, 360.0, 1.0})
    for (int i = -40; i <= 40; ++i) {
      const double difference = 0.1 * i * wrap;
      const double wrapped = wrap_difference(difference, wrap);
      EXPECT_GT(wrapped, -0.5 * wrap);
      EXPECT_LE(wrapped, 0.5 * wrap);
      EXPECT_NEAR(std::remainder(wrapped - difference, wrap), 0.0, kRounding * wrap);
    }
}

TEST(WrapDifference, MapsBothHalvesOfATurnToPlus) {
  EXPECT_EQ(wrap_difference(180.0, 360.0), 180.0);
  EXPECT_EQ(wrap_difference(-180.0, 360.0), 180.0);
  EXPECT_EQ(wrap_difference(540.0, 360.0), 180.0);
}

TEST(Unwrap, RecoversARotationInAnyUnit) {
  for (const double wrap : {kTurn, 360.0}) {
    const VectorXd truth = VectorXd::LinSpaced(500, 0.1 * wrap, -7.3 * wrap);
    VectorXd wrapped = truth;
    for (double& angle : wrapped) angle = wrap_difference(angle, wrap);
    EXPECT_LT((unwrap(wrapped, wrap) - truth).cwiseAbs().maxCoeff(), kRounding * wrap);
  }
}

// A pendulum that hangs on the wrap reads +pi and -pi in turn, within the noise.
TEST(Unwrap, LeavesNoJumpsWhereAnAngleRestsOnTheWrap) {
  VectorXd flicker(10001);
  for (Eigen::Index k = 0; k < flicker.size(); ++k) flicker[k] = (k % 2 == 0 ? 1.0 : -1.0) * (std::numbers::pi - 1e-3);
  const VectorXd smooth = unwrap(flicker, kTurn);
  EXPECT_LT((smooth.array() - std::numbers::pi).abs().maxCoeff(), 1e-3 + kRounding);
  EXPECT_EQ(smooth[10000], flicker[10000]);  // 5,000 turns there and back leave nothing behind
}

TEST(Unwrap, KeepsTheFirstSampleAndWhatHasNoJumps) {
  const VectorXd smooth = VectorXd::LinSpaced(100, 20.0, 25.0);
  EXPECT_EQ(unwrap(smooth, kTurn), smooth);
  EXPECT_EQ(unwrap(VectorXd(), kTurn).size(), 0);
}

TEST(SineAndCosine, GiveTheAngleBackInItsUnit) {
  const VectorXd degrees = VectorXd::LinSpaced(36, -170.0, 180.0);
  const VectorXd back = angle_of(3.0 * sine_of(degrees, 360.0), 3.0 * cosine_of(degrees, 360.0), 360.0);
  EXPECT_LT((back - degrees).cwiseAbs().maxCoeff(), 1e-11);
}

}  // namespace
}  // namespace nlo::trainer
