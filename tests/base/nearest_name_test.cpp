// SPDX-License-Identifier: MIT
#include "trainer/base/nearest_name.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

TEST(NearestName, CountsEdits) {
  EXPECT_EQ(edit_distance("", ""), 0u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("sitting", "kitten"), 3u);
}

TEST(NearestName, FindsATypo) {
  EXPECT_EQ(nearest_name("eigen_values", {"pairs", "eigenvalues", "hold"}), "eigenvalues");
}

TEST(NearestName, TakesTheFirstOfEquals) {
  EXPECT_EQ(nearest_name("ab1", {"ab2", "ab3"}), "ab2");
}

TEST(NearestName, DoesNotGuessWildly) {
  EXPECT_EQ(nearest_name("voltage", {"theta", "time"}), "");
  EXPECT_EQ(nearest_name("x", {}), "");
}

}  // namespace
}  // namespace nlo::trainer
