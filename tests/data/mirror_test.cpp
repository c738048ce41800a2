// SPDX-License-Identifier: MIT
// The rows of a signal that change their sign in a mirror image.
#include "trainer/data/mirror.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

const std::vector<codegen::Channel> kReadings = {{"b", "", 0.0}, {"a_sin", "", 0.0}, {"a_cos", "", 0.0}};

TEST(Mirror, ChangesOnlyTheSineOfAnEncodedAngle) {
  const Mirror mirror = mirror_of({"a", "not_here"}, kReadings, {{"b", "", 0.0}});
  EXPECT_EQ(mirror.readings, (std::vector<bool>{false, true, false}));
  EXPECT_EQ(mirror.states, std::vector<bool>{false});
  EXPECT_EQ(mirror.of_reading(1), -1.0F);
  EXPECT_EQ(mirror.of_reading(2), 1.0F);
  EXPECT_FALSE(mirror.none());
}

TEST(Mirror, IsEmptyWithoutChannels) {
  EXPECT_TRUE(mirror_of({}, kReadings, {}).none());
}

TEST(Mirror, WidensRangesToIncludeMirrorImages) {
  Eigen::VectorXd low = Eigen::Vector3d(-1.0, -3.0, 1.0), high = Eigen::Vector3d(2.0, 1.0, -1.0);
  widen_by_mirror(mirror_of({"a", "a_cos"}, kReadings, {}), low, high);
  EXPECT_EQ(low, Eigen::Vector3d(-1.0, -3.0, 1.0));
  EXPECT_EQ(high, Eigen::Vector3d(2.0, 3.0, -1.0)) << "the last range is empty and stays";
}

}  // namespace
}  // namespace nlo::trainer
