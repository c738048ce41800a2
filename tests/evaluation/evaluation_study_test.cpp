// SPDX-License-Identifier: MIT
#include "trainer/evaluation/evaluation_study.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "trainer/evaluation/comparison.h"
#include "trainer/evaluation/evaluation_text.h"
#include "trainer/evaluation/text.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double kRounding = 1e-12;

/// What an estimator of two states reached: a norm, and the same RMSE of both.
Evaluation reached(const std::string& estimator, double norm, std::uint64_t seed = 1) {
  Evaluation evaluation{estimator, {}, seed, 200, 50.0, {{"x1", "", 0.0}, {"x2", "m", 0.0}}, {{"y", "", 0.0}}, {}, {}};
  evaluation.metrics.norm = norm;
  evaluation.metrics.nrmse = norm;
  evaluation.metrics.per_component = Eigen::Vector2d::Constant(norm);
  evaluation.metrics.windows = {{whole_run().front(), norm, evaluation.metrics.per_component}};
  return evaluation;
}

/// Two models on two test sets: norms 1, 3 of the first and 2, 6 of the second.
EvaluationStudy two_by_two() {
  return {{"a.json", "b.json"},
          {{{reached("observer", 1.0, 7)}, {reached("observer", 3.0, 8)}},
           {{reached("observer", 2.0, 7)}, {reached("observer", 6.0, 8)}}}};
}

const Quantity kNorm = [](const ErrorMetrics& m) { return std::optional(m.norm); };

TEST(EvaluationStudy, StandardErrorsAreThoseOfTheMeansOverTestSetsAndOverModels) {
  const Spread spread = spread_of(two_by_two(), 0, kNorm).value();
  EXPECT_NEAR(spread.mean, 3.0, kRounding);
  EXPECT_NEAR(spread.test_set_error.value(), 1.5, kRounding);       // of 1.5 and 4.5
  EXPECT_NEAR(spread.training_seed_error.value(), 1.0, kRounding);  // of 2 and 4
}

TEST(EvaluationStudy, OneDrawHasNoStandardError) {
  const Spread spread = spread_of({{"a"}, {{{reached("observer", 1.0)}}}}, 0, kNorm).value();
  EXPECT_FALSE(spread.test_set_error.has_value());
  EXPECT_FALSE(spread.training_seed_error.has_value());
}

TEST(EvaluationStudy, AMeanOfSomeIsNoMean) {
  EvaluationStudy study = two_by_two();
  const Quantity nrmse = [](const ErrorMetrics& m) { return m.nrmse; };
  EXPECT_TRUE(spread_of(study, 0, nrmse).has_value());  // control
  study.results[1][0][0].metrics.nrmse.reset();
  EXPECT_FALSE(spread_of(study, 0, nrmse).has_value());
}

TEST(EvaluationStudy, TextAndJsonShowBothErrors) {
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

TEST(EvaluationStudy, TablesStayWithinAHundredColumns) {
  EvaluationStudy study = two_by_two();
  for (auto& by_set : study.results)
    for (auto& group : by_set)
      for (Evaluation& evaluation : group) {
        evaluation.states.insert(evaluation.states.end(), 6, {"angular_velocity", "rad/s", 0.0});
        evaluation.metrics.per_component = Eigen::VectorXd::Constant(8, 0.5);
        for (ErrorMetrics::Window& window : evaluation.metrics.windows)
          window.per_component = evaluation.metrics.per_component;
      }
  const std::string text = evaluation_text(study);
  std::size_t longest = 0;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1)
    longest = std::max(longest, display_width(text.substr(at, text.find('\n', at) - at)));
  EXPECT_LE(longest, 100U) << text;
  EXPECT_GT(longest, 80U) << "the control: nothing that is wide was shown";
}

TEST(ComparisonNotes, CallOutWhatIsNotSeenAndWhatNeedsNoNetwork) {
  const double nan = std::nan("");
  const auto notes = comparison_notes({{"lost", "m", "all", 0.96, 1.0, 0.9},
                                       {"plain", "", "all", 0.5, 1.0, 0.5},
                                       {"good", "", "all", 0.5, 1.0, 0.6},
                                       {"alone", "", "all", 0.5, nan, nan}});
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_THAT(notes[0], HasSubstr("lost is not seen: its error, all: 0.960 m, is no better than that of a constant"));
  EXPECT_THAT(notes[1], HasSubstr("plain needs no network"));
}

TEST(EvaluationStudy, PlantsHaveTheNotesOfLogs) {
  const EvaluationStudy study = {{"a"},
                                 {{{reached("observer", 1.0), reached("constant", 1.0), reached("ridge", 2.0)}}}};
  EXPECT_THAT(evaluation_text(study), HasSubstr("note: x2 is not seen"));
  const EvaluationStudy good = {{"a"}, {{{reached("observer", 1.0), reached("constant", 2.0), reached("ridge", 2.0)}}}};
  EXPECT_THAT(evaluation_text(good), Not(HasSubstr("note:")));
}

}  // namespace
}  // namespace nlo::trainer
