// SPDX-License-Identifier: MIT
#include "trainer/evaluation/text.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

TEST(Text, SignificantDigitsSurviveRoundingUp) {
  EXPECT_EQ(significant(0.18417), "0.184");
  EXPECT_EQ(significant(0.09996), "0.100");
  EXPECT_EQ(significant(9.996), "10.0");
  EXPECT_EQ(significant(1476.0), "1476");
  EXPECT_EQ(significant(0.0), "0");
  EXPECT_EQ(significant(-0.26), "-0.260");
  EXPECT_EQ(significant(3.2e-6), "3.20e-06");
  EXPECT_EQ(significant(2.5e9), "2.50e+09");
  EXPECT_EQ(significant(std::optional<double>()), "-");
}

TEST(Text, ErrorsHaveAPlaceMoreThanTheirMeanUnlessAllRoundToZero) {
  EXPECT_EQ(to_text(Spread{0.0952, 0.0004}), "0.0952 ± 0.00040");
  EXPECT_EQ(to_text(Spread{1.99, 0.0004}), "1.99");
  EXPECT_EQ(to_text(Spread{1.99, 0.0004, 0.02}), "1.99 ± 0.000 ± 0.020");
  EXPECT_EQ(to_text(Spread{1476.0, 3.5}), "1476 ± 3.5");
  EXPECT_EQ(to_text(Spread{2.5e9, 1.3e7}), "2.50e+09 ± 1.3e+07");
}

TEST(Text, StandardErrorsAreOfIndependentDraws) {
  EXPECT_EQ(standard_error(std::vector{1.5, 4.5}), 1.5);
  EXPECT_EQ(deviation_of(std::vector{1.0, 3.0, 5.0}), 2.0);
  EXPECT_FALSE(standard_error(std::vector{1.0})) << "one draw has no scatter";
}

TEST(Text, WidthCountsCodePoints) {
  EXPECT_EQ(display_width("rmse"), 4U);
  EXPECT_EQ(display_width("λ ±█"), 4U);
  EXPECT_EQ(display_width("x\xcc\x82"), 1U);  // x with a combining circumflex
  EXPECT_EQ(display_width("\xcf\x80"), 1U);   // pi: its lead byte is close to those of combining marks
}

TEST(Table, ColumnsLineUp) {
  Table table{{"", "norm", "λ [1/s]"}};
  table.add_row({"observer", "0.1", "-1"});
  table.add_rule();
  table.add_row({"ekf", "12.25"});
  EXPECT_EQ(table.to_text(1),
            "            norm  λ [1/s]\n"
            " ────────────────────────\n"
            " observer    0.1       -1\n"
            " ────────────────────────\n"
            " ekf       12.25\n");
  table.add_row({"of a group whose name is long"});
  table.add_row({"ukf", "1"});
  EXPECT_EQ(table.to_text(1),
            "              norm  λ [1/s]\n"
            " ──────────────────────────\n"
            " observer      0.1       -1\n"
            " ──────────────────────────\n"
            " ekf         12.25\n"
            " ──────────────────────────\n"
            " of a group whose name is long\n"
            "   ukf           1\n");
}

}  // namespace
}  // namespace nlo::trainer
