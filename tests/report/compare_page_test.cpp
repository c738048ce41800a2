// SPDX-License-Identifier: MIT
#include "trainer/report/compare_page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "tests/report/html_checks.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two conditions and all columns of nlo compare; errors of 1, 2, 3 ... but for the tuned EKF.
Comparison sample_comparison() {
  Comparison comparison;
  comparison.experiment = comparison.plant = "van_der_pol";
  for (const char* name : {"gaussian_weak", "parameters_high"}) comparison.conditions.emplace_back().name = name;
  for (const char* name : {"observer", "ekf", "ekf_tuned", "ukf", "ukf_tuned", "joint_ekf", "joint_ekf_tuned", "mhe",
                           "mhe_tuned", "high_gain", "high_gain_tuned", "particle"}) {
    comparison.columns.emplace_back().name = name;
    comparison.columns.back().is_observer = comparison.columns.size() == 1;
  }
  for (int i = 0; i < 2; ++i) {
    auto& cells = comparison.cells.emplace_back();
    for (std::size_t c = 0; c < comparison.columns.size(); ++c) {
      cells.emplace_back().norms = Eigen::Vector2d::Constant(static_cast<double>(c + 1) + 0.5 * i);
      cells.back().tuning = "Q x 10, R x 1, P0 x 1, gate 3";
    }
  }
  return comparison;
}

TEST(ComparePage, HasNamesInWordsAndHeadings) {
  const std::string page = compare_page(sample_comparison(), "no-gnuplot-here");
  for (const char* words : {"EKF, tuned", "joint EKF", "moving horizon, tuned", "particle filter", "parameters high"})
    EXPECT_THAT(page, HasSubstr(words));
  for (const char* identifier : {"ekf_tuned", "joint_ekf", "high_gain", "parameters_high", ">ekf<", ">mhe<"})
    EXPECT_THAT(page, Not(HasSubstr(identifier)));
  EXPECT_THAT(page, HasSubstr("The observer errs less in 2 of 2 conditions than the EKF as shipped"));
  EXPECT_THAT(page, HasSubstr("<td>1.00 *</td>"));
  EXPECT_EQ(nameless(page), 0);
  expect_balanced(page);
}

TEST(ComparePage, DrawsALineForEachConditionInSixColoursTheObserverInFront) {
  if (!gnuplot_is_here()) GTEST_SKIP() << "gnuplot is not installed";
  const std::string page = compare_page(sample_comparison());
  for (const char* line : {">gaussian weak<", ">parameters high<"}) EXPECT_THAT(page, HasSubstr(line));
  std::set<std::string> colours;
  std::string last;
  static const std::regex kMark(R"(<use [^>]* color='([^']*)')");
  for (std::sregex_iterator found(page.begin(), page.end(), kMark), end; found != end; ++found)
    colours.insert(last = (*found)[1]);
  EXPECT_LE(colours.size(), 6U);
  EXPECT_GE(colours.size(), 5U);
  EXPECT_EQ(last, "rgb(217, 114,  26)") << "the observer's";
  EXPECT_THAT(page, HasSubstr("error / error of the EKF, tuned"));
}

}  // namespace
}  // namespace nlo::trainer
