// SPDX-License-Identifier: MIT
#include "trainer/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <regex>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "tests/report/sample_report.h"
#include "trainer/report/gnuplot.h"
#include "trainer/report/html.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int kFewTrajectories = 3;  // enough for every section; the page does not grow with the test set

long occurrences(const std::string& text, const std::string& what) {
  long count = 0;
  for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

/// A tree of open tags: every element that must be closed is, in order.
void expect_balanced(const std::string& html) {
  std::vector<std::string> open;
  static const std::regex kTag(R"(<(/?)([a-zA-Z][a-zA-Z0-9]*)([^<>]*)>)");
  for (std::sregex_iterator tag(html.begin(), html.end(), kTag), end; tag != end; ++tag) {
    const std::string name = (*tag)[2], rest = (*tag)[3];
    if (name == "meta" || (!rest.empty() && rest.back() == '/')) continue;
    if ((*tag)[1].length() == 0) {
      open.push_back(name);
    } else {
      ASSERT_FALSE(open.empty()) << "</" << name << "> closes nothing";
      ASSERT_EQ(open.back(), name);
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty()) << "<" << open.back() << "> stays open";
}

const std::string& sample_page() {
  static const std::string page = render_report(test::sample_report(kFewTrajectories));
  return page;
}

bool gnuplot_is_here() {
  return draw({Figure{"", 200, 100, false, {Panel{}}}}).failure.find("could not be started") == std::string::npos;
}

TEST(Report, HoldsEverySectionOnce) {
  for (const char* heading : {"Errors", "Runs of the test set", "In a control loop", "Training", "How this came about"})
    EXPECT_EQ(occurrences(sample_page(), std::string("<h2>") + heading + "</h2>"), 1) << heading;
  EXPECT_THAT(sample_page(), HasSubstr("N(0, 0.5)"));
  EXPECT_THAT(sample_page(), HasSubstr("extended Kalman filter"));
}

TEST(Report, HasAPlotForEachPartOfTheRun) {
  if (!gnuplot_is_here()) GTEST_SKIP() << "gnuplot is not installed";
  // Error over time, the runs, the start of the first, latency, training, eigenvalues over steps, eigenvalue map.
  const auto runs = static_cast<long>(test::sample_report(kFewTrajectories).evaluations[1][0].examples.size());
  EXPECT_EQ(occurrences(sample_page(), "<svg"), runs + 6);
  EXPECT_THAT(sample_page(), Not(HasSubstr("The plots are missing")));
}

TEST(Report, IsSelfContainedAndBalanced) {
  for (const char* reference : {"<script", "src=", "<link", "@import", "url("})
    EXPECT_THAT(sample_page(), Not(HasSubstr(reference)));
  // What remains of addresses are the names of XML vocabularies, which nothing fetches.
  EXPECT_EQ(occurrences(sample_page(), "http"), occurrences(sample_page(), "xmlns"));
  expect_balanced(sample_page());
}

TEST(Report, ShowsNoNan) {
  const std::string text = std::regex_replace(sample_page(), std::regex("<[^<>]*>"), " ");
  EXPECT_FALSE(std::regex_search(text, std::regex(R"((^|[^a-zA-Z])-?(nan|inf)($|[^a-zA-Z]))")));
}

TEST(Report, EscapesNamesFromOutside) {
  ReportData data = test::sample_report(kFewTrajectories);
  const std::string evil = "<img src=x>'; system('touch EVIL') \"`touch EVIL`\n!touch EVIL";
  data.title = evil;
  data.facts = {{evil, evil}};
  for (auto& group : data.evaluations)
    for (Evaluation& evaluation : group) {
      evaluation.estimator = evil;
      for (Channel& state : evaluation.states) state.name = state.unit = evil;
    }
  const std::string page = render_report(data);
  EXPECT_THAT(page, Not(HasSubstr("<img")));
  EXPECT_FALSE(std::filesystem::exists("EVIL"));
  expect_balanced(page);
  if (gnuplot_is_here()) {
    EXPECT_THAT(page, Not(HasSubstr("The plots are missing")));
  }
}

TEST(Report, SaysSoWhenGnuplotIsMissingOrFails) {
  const ReportData data = test::sample_report(kFewTrajectories);
  for (const char* program : {"no-such-gnuplot", "false"}) {
    const std::string page = render_report(data, program);
    EXPECT_EQ(occurrences(page, "The plots are missing"), 1) << program;
    EXPECT_THAT(page, HasSubstr("gnuplot-nox"));
    EXPECT_THAT(page, HasSubstr("<table>"));
    expect_balanced(page);
  }
}

TEST(Report, WarnsBeforeAllElse) {
  ReportData data = test::sample_report(kFewTrajectories);
  EXPECT_THAT(render_report(data, "false"), Not(HasSubstr("class=\"alarm\"")));
  data.warning = "the training got <nowhere>";
  const std::string page = render_report(data, "false");
  EXPECT_THAT(page, HasSubstr("the training got &lt;nowhere&gt;"));
  EXPECT_LT(page.find("class=\"alarm\""), page.find("class=\"summary\""));
  expect_balanced(page);
}

TEST(Report, DrawsTheFirstAndTheWorstRun) {
  if (!gnuplot_is_here()) GTEST_SKIP() << "gnuplot is not installed";
  ReportData data = test::sample_report(kFewTrajectories);
  std::vector<EvaluatedRun>& examples = data.evaluations[1][0].examples;  // Gaussian noise: the group that is drawn
  examples.resize(1, {});
  const long alone = occurrences(render_report(data), "<svg");
  examples.push_back(examples[0]);
  examples[0].why = "first";
  examples[1].why = "worst";
  const std::string page = render_report(data);
  EXPECT_EQ(occurrences(page, "<svg"), alone + 1);
  EXPECT_EQ(occurrences(page, "(first of 3)"), 1);
  EXPECT_EQ(occurrences(page, "(worst of 3)"), 1);
  EXPECT_EQ(occurrences(page, "2 of the 3 runs: the first and the worst"), 1);
}

TEST(Report, DrawsEveryTestLogOrEightOfThem) {
  if (!gnuplot_is_here()) GTEST_SKIP() << "gnuplot is not installed";
  for (const int count : {1, 3, 11}) {
    ReportData data;
    data.title = "logs";
    data.logs = test::sample_logs(count);
    const std::string page = render_report(data);
    const int drawn = std::min(count, 8);
    EXPECT_EQ(occurrences(page, "<svg"), drawn + 1) << "each log, and the start of the first";
    EXPECT_EQ(occurrences(page, "8 of the 11 runs: the first, the best, the worst"), count == 11 ? 1 : 0);
    for (const char* log : {"run_1.csv", "run_11.csv"})  // the first, which is the best, and the worst
      EXPECT_EQ(occurrences(page, std::string("<figcaption>") + log), count == 11 || log == std::string("run_1.csv"));
    EXPECT_EQ(occurrences(page, "Grey: not scored, the truth is masked there, 10 % of the samples."), drawn);
    EXPECT_EQ(occurrences(page, "Purple: z is outside of the training domain, 2.0 % of the samples."), drawn);
    expect_balanced(page);
  }
}

TEST(Report, SaysWhichLogsTheseAre) {
  ReportData data;
  data.logs = test::sample_logs(2);
  EXPECT_THAT(render_report(data, "false"), HasSubstr("On 2 logs that were not used for training"));
  data.logs->split = "validation";
  const std::string page = render_report(data, "false");
  EXPECT_THAT(page, HasSubstr("On 2 validation logs: "));
  EXPECT_THAT(page, Not(HasSubstr("not used for training")));
  EXPECT_THAT(page, Not(HasSubstr("unseen")));
}

TEST(Report, AddsUpErrorsOfOneUnitOnly) {
  if (!gnuplot_is_here()) GTEST_SKIP() << "gnuplot is not installed";
  ReportData data = test::sample_report(kFewTrajectories);
  for (auto& group : data.evaluations)
    for (Evaluation& evaluation : group) evaluation.states[1].unit = "rad/s";
  EXPECT_EQ(occurrences(render_report(data), "<svg"), occurrences(sample_page(), "<svg") - 1);
}

TEST(Report, EmptyDataStillMakeAPage) {
  ReportData data;
  data.title = "nothing";
  expect_balanced(render_report(data));
}

TEST(Report, BalanceCheckFindsAnOpenTag) {  // control
  testing::TestPartResultArray failures;
  {
    testing::ScopedFakeTestPartResultReporter reporter(
        testing::ScopedFakeTestPartResultReporter::INTERCEPT_ONLY_CURRENT_THREAD, &failures);
    expect_balanced("<div><p></div>");
  }
  EXPECT_GT(failures.size(), 0);
}

TEST(GnuplotQuoted, LeavesNoWayOut) {
  EXPECT_EQ(gnuplot_quoted("x1 [m]"), "'x1 [m]'");
  EXPECT_EQ(gnuplot_quoted("it's"), "'it''s'");
  EXPECT_EQ(gnuplot_quoted("a\nsystem 'x'\r\x7f"), "'asystem ''x'''");
}

TEST(Thinned, KeepsTheFirstAndStaysBelowTheLimit) {
  const Eigen::VectorXd values = Eigen::VectorXd::LinSpaced(2501, 0.0, 50.0);
  EXPECT_LE(thinned(values, 800).size(), 800);
  EXPECT_EQ(thinned(values, 800)[0], 0.0);
  EXPECT_EQ(thinned(values, 2501), values);
  EXPECT_EQ(thinned(Eigen::VectorXd(), 10).size(), 0);
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

TEST(TrainingCurves, DamageIsNamedByLine) {
  const auto message = [](const char* csv) -> std::string {
    try {
      parse_training_curves(csv, "metrics.csv");
    } catch (const codegen::Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message(""), HasSubstr("metrics.csv: is empty"));
  EXPECT_THAT(message("loss\n1\n"), HasSubstr("no column \"step\""));
  EXPECT_THAT(message("step,loss\n1,2\n3\n"), HasSubstr("metrics.csv:3: has 1 cells"));
  EXPECT_THAT(message("step\n0x7\n"), HasSubstr("metrics.csv:2: \"0x7\" is not a number"));
}

TEST(ControlLoopResult, ReadsWhatTheExampleWrites) {
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

TEST(ControlLoopResult, NamesWhatIsMissing) {
  for (const char* text : {"", "[]", "{\"rate_hz\": 1000}", "{\"rate_hz\": \"fast\"}"})
    EXPECT_THROW(parse_control_loop(text, "control_loop.json"), codegen::Error) << text;
}

TEST(ReportOf, TakesWhatLiesInTheRunDirectory) {
  const auto directory = std::filesystem::temp_directory_path() / ("nlo-report-test-" + std::to_string(getpid()));
  std::filesystem::create_directory(directory);
  codegen::Model model;
  model.name = "m";
  EXPECT_FALSE(report_of(model, directory.string()).training.has_value());
  codegen::write_file_atomically((directory / "metrics.csv").string(), "step,loss\n0,1\n");
  codegen::write_file_atomically((directory / "control_loop.json").string(), "{}");
  codegen::write_file_atomically((directory / "model.json").string(), "{}");
  // A result older than the model is another model's: left out, and not even read.
  std::filesystem::last_write_time(directory / "control_loop.json",
                                   std::filesystem::last_write_time(directory / "model.json") - std::chrono::hours(1));
  const ReportData data = report_of(model, directory.string());
  EXPECT_TRUE(data.training.has_value());
  EXPECT_FALSE(data.control_loop.has_value());
  std::filesystem::remove_all(directory);
}

TEST(SampleReport, WriteForViewing) {
  const char* path = std::getenv("NLO_SAMPLE_REPORT");
  if (path == nullptr) GTEST_SKIP() << "set NLO_SAMPLE_REPORT=FILE.html to look at the page";
  write_report(test::sample_report(), path);
}

}  // namespace
}  // namespace nlo::trainer
