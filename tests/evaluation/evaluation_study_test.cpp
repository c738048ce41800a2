// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/evaluation_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/support/row_of.h"
#include "trainer/judge/evaluation/evaluation_text.h"
#include "trainer/judge/evaluation/text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kRounding = 1e-12;

/// The result of an estimator of two states: a norm, and the same RMSE for both states.
Evaluation reached(const std::string& estimator, double norm, std::uint64_t seed = 1) {
  Evaluation evaluation{estimator, {}, seed, 200, 50.0, {{"x1", "", 0.0}, {"x2", "m", 0.0}}, {{"y", "", 0.0}}, {}, {}};
  evaluation.metrics.norm = norm;
  evaluation.metrics.nrmse = norm;
  evaluation.metrics.per_component = Eigen::Vector2d::Constant(norm);
  evaluation.metrics.windows = {{whole_run().front(), norm, evaluation.metrics.per_component}};
  return evaluation;
}

/// Two models on two test sets: norms 1, 3 of the first and 2, 6 of the second.
StudyRow two_by_two() {
  return {{"a.json", "b.json"},
          {{{{reached("observer", 1.0, 7), reached("observer", 3.0, 8)},
             {reached("observer", 2.0, 7), reached("observer", 6.0, 8)}}}}};
}

const Quantity kNorm = [](const ErrorMetrics& m) { return std::optional(m.norm); };

TEST(StudyRow, HasStandardErrorsOverTestSetsAndOverModels) {
  const Spread spread = spread_of(two_by_two().observer(), kNorm).value();
  EXPECT_NEAR(spread.mean, 3.0, kRounding);
  EXPECT_NEAR(spread.test_set_error.value(), 1.5, kRounding);       // from 1.5 and 4.5
  EXPECT_NEAR(spread.training_seed_error.value(), 1.0, kRounding);  // from 2 and 4
}

TEST(StudyRow, OneDrawHasNoStandardError) {
  const Spread spread = norm_of(row_of("a", {reached("observer", 1.0)}).observer());
  EXPECT_FALSE(spread.test_set_error.has_value());
  EXPECT_FALSE(spread.training_seed_error.has_value());
}

TEST(StudyRow, HasNoMeanIfAResultIsMissing) {
  StudyCell cell = two_by_two().observer();
  const Quantity nrmse = [](const ErrorMetrics& m) { return m.nrmse; };
  EXPECT_TRUE(spread_of(cell, nrmse).has_value());  // control
  cell.evaluations[1][0].metrics.nrmse.reset();
  EXPECT_FALSE(spread_of(cell, nrmse).has_value());
}

TEST(StudyRow, TextAndJsonShowBothErrors) {
  const std::string text = evaluation_text(two_by_two());
  EXPECT_THAT(text, HasSubstr("2 models of one experiment on 2 test sets of 200 trajectories of 50 s"));
  EXPECT_THAT(text, HasSubstr("seeds 7 to 8"));
  EXPECT_THAT(text, HasSubstr("3.00 ± 1.500 ± 1.000"));
  const auto json = nlohmann::json::parse(evaluation_json(two_by_two(), 1.0));
  EXPECT_EQ(json.at("norm"), 3.0);
  EXPECT_EQ(json.at("standard_error").at("over_test_sets").at("norm"), 1.5);
  EXPECT_EQ(json.at("standard_error").at("over_training_seeds").at("per_component").at(1), 1.0);
  EXPECT_EQ(json.at("test_sets"), 2);
  EXPECT_EQ(json.at("models").size(), 2U);
}

TEST(StudyRow, TablesStayWithinAHundredColumns) {
  StudyRow row = two_by_two();
  for (StudyCell& cell : row.cells)
    for (auto& by_test_set : cell.evaluations)
      for (Evaluation& evaluation : by_test_set) {
        evaluation.states.insert(evaluation.states.end(), 6, {"angular_velocity", "rad/s", 0.0});
        evaluation.metrics.per_component = Eigen::VectorXd::Constant(8, 0.5);
        for (ErrorMetrics::Window& window : evaluation.metrics.windows)
          window.per_component = evaluation.metrics.per_component;
      }
  const std::string text = evaluation_text(row);
  std::size_t longest = 0;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
    longest = std::max(longest, display_width(text.substr(at, text.find('\n', at) - at)));
  EXPECT_LE(longest, 100U) << text;
  EXPECT_GT(longest, 80U) << "control: no wide table was shown";
}

TEST(ComparisonNotes, NameUndeterminedStatesAndStatesThatNeedNoNetwork) {
  const double nan = std::nan("");
  const auto notes = comparison_notes({{"lost", "m", "all", 0.96, 1.0, 0.9},
                                       {"plain", "", "all", 0.5, 1.0, 0.5},
                                       {"good", "", "all", 0.5, 1.0, 0.6},
                                       {"alone", "", "all", 0.5, nan, nan}});
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_THAT(
      notes[0],
      HasSubstr("lost is not observed: its error in the window all is 0.960 m, not clearly below that of a constant"));
  EXPECT_THAT(notes[1], HasSubstr("plain does not need a network"));
}

TEST(StudyRow, GivesTheSameNotesForPlantsAsForLogs) {
  const StudyRow row = row_of("a", {reached("observer", 1.0), reached("constant", 1.0), reached("ridge", 2.0)});
  EXPECT_THAT(evaluation_text(row), HasSubstr("note: x2 is not observed"));
  const StudyRow good = row_of("a", {reached("observer", 1.0), reached("constant", 2.0), reached("ridge", 2.0)});
  EXPECT_THAT(evaluation_text(good), Not(HasSubstr("note:")));
}

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

TEST(Text, ErrorsHaveOneDigitMoreThanTheirMeanUnlessAllRoundToZero) {
  EXPECT_EQ(to_text(Spread{0.0952, 0.0004}), "0.0952 ± 0.00040");
  EXPECT_EQ(to_text(Spread{1.99, 0.0004}), "1.99");
  EXPECT_EQ(to_text(Spread{1.99, 0.0004, 0.02}), "1.99 ± 0.000 ± 0.020");
  EXPECT_EQ(to_text(Spread{1476.0, 3.5}), "1476 ± 3.5");
  EXPECT_EQ(to_text(Spread{2.5e9, 1.3e7}), "2.50e+09 ± 1.3e+07");
}

TEST(Text, StandardErrorsUseIndependentDraws) {
  EXPECT_EQ(standard_error(std::vector{1.5, 4.5}), 1.5);
  EXPECT_EQ(deviation_of(std::vector{1.0, 3.0, 5.0}), 2.0);
  EXPECT_FALSE(standard_error(std::vector{1.0})) << "one draw has no standard error";
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
