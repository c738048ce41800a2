// SPDX-License-Identifier: MIT
// The page of a comparison, and the files that a report reads: curves of a training and the result of a control loop.
#include "trainer/app/report/pages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <regex>
#include <set>

#include "codegen/base/error.h"
#include "tests/report/html_checks.h"
#include "tests/support/thrown_message.h"
#include "trainer/app/report/run_results.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

/// Two conditions with all columns of nlo evaluate --conditions; errors are 1, 2, 3 ... except those of the tuned EKF.
Study sample_comparison() {
  Study study;
  study.experiment = study.plant = "van_der_pol";
  for (const char* name : {"gaussian_weak", "parameters_high"}) study.test.conditions.emplace_back().name = name;
  for (const char* name : {"observer", "ekf", "ekf_tuned", "ukf", "ukf_tuned", "joint_ekf", "joint_ekf_tuned", "mhe",
                           "mhe_tuned", "high_gain", "high_gain_tuned", "particle"}) {
    study.estimators.emplace_back().name = name;
    study.estimators.back().is_observer = study.estimators.size() == 1;
  }
  for (int i = 0; i < 2; ++i) {
    auto& cells = study.rows.emplace_back().cells;
    for (std::size_t c = 0; c < study.estimators.size(); ++c) {
      Evaluation evaluation;
      evaluation.metrics.norm = static_cast<double>(c + 1) + 0.5 * i;
      cells.emplace_back().evaluations = {{evaluation, evaluation}};
      cells.back().tuning = "Q x 10, R x 1, P0 x 1, gate 3";
    }
  }
  return study;
}

TEST(ComparePage, NamesEstimatorsInWords) {
  const std::string page = compare_page(sample_comparison(), "no-gnuplot-here");
  for (const char* words : {"EKF, tuned", "joint EKF", "moving horizon, tuned", "particle filter", "parameters high"})
    EXPECT_THAT(page, HasSubstr(words));
  for (const char* identifier : {"ekf_tuned", "joint_ekf", "high_gain", "parameters_high", ">ekf<", ">mhe<"})
    EXPECT_THAT(page, Not(HasSubstr(identifier)));
  EXPECT_THAT(page, HasSubstr("The observer has a smaller error in 2 of 2 conditions than the EKF as shipped"));
  EXPECT_THAT(page, HasSubstr("<td>1.00 *</td>"));
  EXPECT_EQ(nameless(page), 0);
  expect_balanced(page);
}

TEST(ComparePage, DrawsALineForEachConditionInSixColoursWithTheObserverInFront) {
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
  EXPECT_EQ(last, "rgb(217, 114,  26)") << "the colour of the observer";
  EXPECT_THAT(page, HasSubstr("error / error of the EKF, tuned"));
}

TEST(TrainingCurves, ReadBackByHeading) {
  const TrainingCurves curves = parse_training_curves(
      "loss,step,unknown,lambda_1_im,lambda_1_re\r\n0.5,0,7,2,-1\r\n,100,7,2.5,-1.5\r\n", "metrics.csv");
  EXPECT_EQ(curves.step[1], 100.0);
  EXPECT_EQ(curves.loss[0], 0.5);
  EXPECT_TRUE(std::isnan(curves.loss[1]));
  ASSERT_EQ(curves.eigenvalues.size(), 1U);
  EXPECT_EQ(curves.eigenvalues[0][1], std::complex<double>(-1.5, 2.5));
}

TEST(TrainingCurves, ErrorsNameTheDamagedLine) {
  const auto message = [](const char* csv) -> std::string {
    return thrown_message([&] { parse_training_curves(csv, "metrics.csv"); });
  };
  EXPECT_THAT(message(""), HasSubstr("metrics.csv: is empty"));
  EXPECT_THAT(message("loss\n1\n"), HasSubstr("no column \"step\""));
  EXPECT_THAT(message("step,loss\n1,2\n3\n"), HasSubstr("metrics.csv:3: has 1 cells"));
  EXPECT_THAT(message("step\n0x7\n"), HasSubstr("metrics.csv:2: \"0x7\" is not a number"));
}

TEST(ControlLoopResult, ReadsTheFileOfTheExample) {
  const ControlLoopResult result = parse_control_loop(R"({"rate_hz": 1000, "ticks": 500, "sample_period_s": 0.02,
    "noise_std": 0.5, "seed": 1, "rms_error": 0.17, "settled_rms_error": 0.08, "missed_deadlines": 2, "faults": 0,
    "outside_domain": 3, "real_time_priority": true, "memory_locked": false,
    "step_and_estimate_ns": {"p50": 200, "p99": 300, "p99_9": 400, "max": 5000},
    "wake_up_lateness_ns": {"p50": 1, "p99": 2, "p99_9": 3, "max": 4},
    "step_and_estimate_histogram": [{"below_ns": 244, "count": 499}, {"below_ns": 305, "count": 1}]})",
                                                      "control_loop.json");
  EXPECT_EQ(result.missed_deadlines, 2);
  EXPECT_EQ(result.step_and_estimate.p99_9, 400.0);
  ASSERT_EQ(result.histogram.size(), 2U);
  EXPECT_EQ(result.histogram[0].count, 499.0);
}

TEST(ControlLoopResult, NamesMissingFields) {
  for (const char* text : {"", "[]", "{\"rate_hz\": 1000}", "{\"rate_hz\": \"fast\"}"})
    EXPECT_THROW(parse_control_loop(text, "control_loop.json"), codegen::Error) << text;
}

}  // namespace
}  // namespace nlo::trainer
