// SPDX-License-Identifier: MIT
// Numbers beside the paper's: statistics, marks, CSV.
#include "trainer/reproduce/section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "trainer/reproduce/csv.h"

namespace nlo::trainer::reproduction {
namespace {

TEST(Spread, IsMeanAndPopulationDeviation) {
  const Spread s = spread({1.0, 2.0, 3.0});
  EXPECT_DOUBLE_EQ(s.mean, 2.0);
  EXPECT_DOUBLE_EQ(s.deviation, std::sqrt(2.0 / 3.0));  // divided by n, not n - 1
  EXPECT_TRUE(std::isnan(spread({}).mean));
}

TEST(Cell, IsMarkedBeyondThirtyFivePercentInThePaperLikeReading) {
  const double inside = 1.34, outside = 1.36;
  EXPECT_FALSE(is_outside({1.0, {5.0}, {inside}}));
  EXPECT_TRUE(is_outside({1.0, {1.0}, {outside}}));
  EXPECT_TRUE(is_outside({1.0, {1.0}, {2.0 - outside}}));
  EXPECT_FALSE(is_outside({std::nullopt, {1.0}, {99.0}}));
}

Section two_cells() {
  Section section;
  section.tables.push_back(
      {"", "noise", {"a, quoted", "b"}, {"none"}, {{{0.5, {1.0, 3.0}, {0.25, 0.75}}, {std::nullopt, {2.0}, {}}}}});
  return section;
}

TEST(NumbersCsv, HasALinePerCellAndReading) {
  EXPECT_EQ(numbers_csv(two_cells()),
            "table,row,column,reading,metric,paper,mean,deviation,relative_to_paper,seed_1,seed_2\n"
            ",none,\"a, quoted\",strict,norm,0.5,2,1,,1,3\n"
            ",none,\"a, quoted\",paper-like,nrmse,0.5,0.5,0.25,0,0.25,0.75\n"
            ",none,b,strict,norm,,2,0,,2\n");
  EXPECT_EQ(numbers_csv({}), "");
}

TEST(ColumnsCsv, WritesColumnsSideBySide) {
  const Eigen::VectorXd time = Eigen::Vector2d(0.0, 0.5), x = Eigen::Vector2d(-1.0, 0.1);
  EXPECT_EQ(columns_csv({{"time_s", time}, {"x1", x}}), "time_s,x1\n0,-1\n0.5,0.1\n");
}

}  // namespace
}  // namespace nlo::trainer::reproduction
