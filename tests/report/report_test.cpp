// SPDX-License-Identifier: MIT
#include "trainer/app/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <utility>

#include "codegen/base/file.h"
#include "tests/report/html_checks.h"
#include "tests/report/sample_report.h"
#include "tests/support/scratch_directory.h"
#include "trainer/app/report/figures.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int kFewTrajectories = 3;  // enough for every section; the size of the page does not depend on the test set

const std::string& sample_page() {
  static const std::string page = render_report(test::sample_report(kFewTrajectories));
  return page;
}

TEST(Report, HoldsEverySectionOnce) {
  for (const char* heading :
       {"Errors", "Runs of the test set", "In a control loop", "Training", "How this model was made"})
    EXPECT_EQ(occurrences(sample_page(), std::string("<h2>") + heading + "</h2>"), 1) << heading;
  EXPECT_THAT(sample_page(), HasSubstr("N(0, 0.5)"));
  EXPECT_THAT(sample_page(), HasSubstr("extended Kalman filter"));
}

TEST(Report, HasAPlotForEachPartOfTheRun) {
  if (!gnuplot_is_here()) GTEST_SKIP() << "gnuplot is not installed";
  // The six other plots are: error over time, start of the first run, latency, training, eigenvalues over steps, map of
  // eigenvalues.
  const auto runs = static_cast<long>(test::sample_report(kFewTrajectories).rows[1].observer().first().examples.size());
  EXPECT_EQ(occurrences(sample_page(), "<svg"), runs + 6);
  EXPECT_THAT(sample_page(), Not(HasSubstr("The plots are missing")));
}

TEST(Report, IsSelfContainedAndBalanced) {
  for (const char* reference : {"<script", "src=", "<link", "@import", "url("})
    EXPECT_THAT(sample_page(), Not(HasSubstr(reference)));
  // The only addresses are names of XML vocabularies, which no browser loads.
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
  for (StudyRow& row : data.rows)
    for (StudyCell& cell : row.cells) {
      Evaluation& evaluation = cell.first();
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
    EXPECT_THAT(page, HasSubstr("<table"));
    expect_balanced(page);
  }
}

TEST(Report, BeginsWithTheWarning) {
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
  std::vector<EvaluatedRun>& examples = data.rows[1].cells[0].first().examples;  // the row with Gaussian noise is drawn
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
    EXPECT_EQ(occurrences(page, "<svg"), drawn + 1) << "each log, and the start of the first log";
    EXPECT_EQ(occurrences(page, "8 of the 11 runs: the first, the best, the worst"), count == 11 ? 1 : 0);
    for (const char* log : {"run_1.csv", "run_11.csv"})  // the first, which is the best, and the worst
      EXPECT_EQ(occurrences(page, std::string("<figcaption>") + log), count == 11 || log == std::string("run_1.csv"));
    EXPECT_EQ(occurrences(page, "Grey: not scored, the truth is masked there, 10.0 % of the samples."), drawn);
    EXPECT_EQ(occurrences(page, "Purple: z is outside of the training domain, 2.00 % of the samples."), drawn);
    expect_balanced(page);
  }
}

TEST(Report, SaysWhichLogsItShows) {
  ReportData data;
  data.logs = test::sample_logs(2);
  EXPECT_THAT(render_report(data, "false"), HasSubstr("On 2 logs that were not used for training"));
  data.logs->split = "validation";
  const std::string page = render_report(data, "false");
  EXPECT_THAT(page, HasSubstr("On 2 validation logs: "));
  EXPECT_THAT(page, Not(HasSubstr("not used for training")));
  EXPECT_THAT(page, Not(HasSubstr("unseen")));
}

TEST(Report, ShowsOnlyAvailableFactsOfLogs) {
  ReportData data;
  data.logs = test::sample_logs(2);
  EXPECT_THAT(render_report(data, "false"), Not(HasSubstr("Truth of")));
  EXPECT_THAT(render_report(data, "false"), Not(HasSubstr("Alternatives"))) << "there are none";
  data.derived_states = {"rate"};
  EXPECT_THAT(render_report(data, "false"), HasSubstr("Truth of rate: the slope of a logged column"));
}

TEST(Report, MentionsAKalmanFilterOnlyIfOneWasTested) {
  ReportData data = test::sample_report(kFewTrajectories);
  EXPECT_THAT(error_figure(data.rows).caption, HasSubstr("Dashed: the extended Kalman filter"));  // control
  for (StudyRow& row : data.rows)
    std::erase_if(row.cells, [](const StudyCell& cell) { return cell.first().estimator == "ekf"; });
  EXPECT_THAT(render_report(data), Not(HasSubstr("Kalman")));
  EXPECT_THAT(error_figure(data.rows).caption, Not(HasSubstr("Dashed")));
}

TEST(Report, HasAColumnForSettledErrorsOnlyIfThereAreSome) {
  ReportData data = test::sample_report(kFewTrajectories);
  for (StudyRow& row : data.rows)
    for (StudyCell& cell : row.cells) cell.first().metrics.windows.push_back({{"settled", 10.0, 50.0}, {}, {}});
  for (const char* heading : {">settled (", ">settling time [s]<"}) {
    EXPECT_THAT(render_report(data, "false"), Not(HasSubstr(heading)));
    ErrorMetrics& metrics = data.rows[1].cells[0].first().metrics;
    const ErrorMetrics unsettled = std::exchange(metrics, [&] {
      ErrorMetrics settled = metrics;
      settled.settled = settled.windows.back().norm = 0.1;
      return settled;
    }());
    EXPECT_THAT(render_report(data, "false"), HasSubstr(heading));
    metrics = unsettled;
  }
}

TEST(Report, DistinguishesAlternativesUnderTheSameNoise) {
  ReportData data = test::sample_report(kFewTrajectories);
  data.rows.resize(1);
  data.rows[0].cells.push_back(data.rows[0].cells[1]);
  data.rows[0].cells.back().first().estimator = "ukf";
  const std::vector<Series> lines = error_figure(data.rows).panels[0].series;
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_NE(lines[1].colour, lines[2].colour);
  EXPECT_EQ(lines[0].colour, lines[1].colour) << "dashed";
}

TEST(Report, LabelsEveryPictureAndEveryTableCell) {
  EXPECT_EQ(nameless(sample_page()), 0);
  EXPECT_GT(occurrences(sample_page(), "<th scope=\"row\""), 9);
  EXPECT_EQ(nameless("<thead><th>a</th><svg><svg role=\"img\" aria-label=\"\"><title>gnuplot_plot_1</title>"), 4)
      << "control";
}

TEST(Report, AddsUpOnlyErrorsOfTheSameUnit) {
  if (!gnuplot_is_here()) GTEST_SKIP() << "gnuplot is not installed";
  ReportData data = test::sample_report(kFewTrajectories);
  for (StudyRow& row : data.rows)
    for (StudyCell& cell : row.cells) cell.first().states[1].unit = "rad/s";
  EXPECT_EQ(occurrences(render_report(data), "<svg"), occurrences(sample_page(), "<svg") - 1);
}

TEST(Report, WritesAPageForEmptyData) {
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

TEST(ReportOf, ReadsTheFilesOfTheRunDirectory) {
  const ScratchDirectory directory;
  codegen::Model model;
  model.name = "m";
  EXPECT_FALSE(report_of(model, directory.path()).training.has_value());
  directory.write("metrics.csv", "step,loss\n0,1\n");
  directory.write("control_loop.json", "{}");
  directory.write("model.json", "{}");
  // A result older than the model belongs to another model, so it is left out and not even read.
  std::filesystem::last_write_time(
      directory.path("control_loop.json"),
      std::filesystem::last_write_time(directory.path("model.json")) - std::chrono::hours(1));
  const ReportData data = report_of(model, directory.path());
  EXPECT_TRUE(data.training.has_value());
  EXPECT_FALSE(data.control_loop.has_value());
}

TEST(SampleReport, IsWrittenForViewing) {
  const char* path = std::getenv("NLO_SAMPLE_REPORT");
  if (path == nullptr) GTEST_SKIP() << "set NLO_SAMPLE_REPORT=FILE.html to write the page";
  write_report(test::sample_report(), path);
}

}  // namespace
}  // namespace nlo::trainer
