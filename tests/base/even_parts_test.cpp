// SPDX-License-Identifier: MIT
#include "trainer/base/even_parts.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace nlo::trainer {
namespace {

TEST(EvenParts, CoverARangeInOrderAndDifferByOneAtMost) {
  for (int count = 0; count <= 60; ++count) {
    int next = 0, least = count, most = 0, parts = 0;
    in_even_parts<6>(count, [&](auto size, int first) {
      EXPECT_EQ(first, next);
      next += size();
      least = std::min(least, size());
      most = std::max(most, size());
      ++parts;
    });
    EXPECT_EQ(next, count);
    EXPECT_EQ(parts, (count + 5) / 6);
    EXPECT_LE(most - least, count > 0 ? 1 : 0) << count;
  }
}

}  // namespace
}  // namespace nlo::trainer
