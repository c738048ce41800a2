// SPDX-License-Identifier: MIT
#include "trainer/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <tuple>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "tests/report/sample_report.h"
#include "trainer/report/compare_page.h"
#include "trainer/report/figures.h"
#include "trainer/report/gnuplot.h"
#include "trainer/report/gnuplot_script.h"
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
    EXPECT_THAT(page, HasSubstr("<table"));
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
    EXPECT_EQ(occurrences(page, "Grey: not scored, the truth is masked there, 10.0 % of the samples."), drawn);
    EXPECT_EQ(occurrences(page, "Purple: z is outside of the training domain, 2.00 % of the samples."), drawn);
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

TEST(Report, SaysOfLogsOnlyWhatTheyHave) {
  ReportData data;
  data.logs = test::sample_logs(2);
  EXPECT_THAT(render_report(data, "false"), Not(HasSubstr("Truth of")));
  EXPECT_THAT(render_report(data, "false"), Not(HasSubstr("Alternatives"))) << "there are none";
  data.derived_states = {"rate"};
  EXPECT_THAT(render_report(data, "false"), HasSubstr("Truth of rate: the slope of a logged column"));
}

TEST(Report, SpeaksOfAKalmanFilterOnlyWhereThereIsOne) {
  ReportData data = test::sample_report(kFewTrajectories);
  EXPECT_THAT(error_figure(data.evaluations).caption, HasSubstr("Dashed: the extended Kalman filter"));  // control
  for (auto& group : data.evaluations) std::erase_if(group, [](const Evaluation& e) { return e.estimator == "ekf"; });
  EXPECT_THAT(render_report(data), Not(HasSubstr("Kalman")));
  EXPECT_THAT(error_figure(data.evaluations).caption, Not(HasSubstr("Dashed")));
}

TEST(Report, HasAColumnForSettledErrorsOnlyWhereThereAreSome) {
  ReportData data = test::sample_report(kFewTrajectories);
  for (auto& group : data.evaluations)
    for (Evaluation& evaluation : group) evaluation.metrics.windows.push_back({{"settled", 10.0, 50.0}, {}, {}});
  for (const char* heading : {">settled (", ">settling time [s]<"}) {
    EXPECT_THAT(render_report(data, "false"), Not(HasSubstr(heading)));
    ErrorMetrics& metrics = data.evaluations[1][0].metrics;
    const ErrorMetrics unsettled = std::exchange(metrics, [&] {
      ErrorMetrics settled = metrics;
      settled.settled = settled.windows.back().norm = 0.1;
      return settled;
    }());
    EXPECT_THAT(render_report(data, "false"), HasSubstr(heading));
    metrics = unsettled;
  }
}

TEST(Report, TellsAlternativesOfOneNoiseApart) {
  ReportData data = test::sample_report(kFewTrajectories);
  data.evaluations.resize(1);
  data.evaluations[0].push_back(data.evaluations[0][1]);
  data.evaluations[0].back().estimator = "ukf";
  const std::vector<Series> lines = error_figure(data.evaluations).panels[0].series;
  ASSERT_EQ(lines.size(), 3U);
  EXPECT_NE(lines[1].colour, lines[2].colour);
  EXPECT_EQ(lines[0].colour, lines[1].colour) << "dashed";
}

/// Pictures without a role and a label, headings that do not say what they head, gnuplot's own titles.
long nameless(const std::string& page) {
  long count = occurrences(page, "gnuplot_plot");
  static const std::regex kPicture(
      R"re(<svg(?! role="img" aria-label="[^"]+")|<th(?=[ >])(?! scope="(col|row|rowgroup)"))re");
  for (std::sregex_iterator found(page.begin(), page.end(), kPicture), end; found != end; ++found) ++count;
  return count;
}

TEST(Report, NamesEveryPictureAndHeadsEveryCell) {
  EXPECT_EQ(nameless(sample_page()), 0);
  EXPECT_GT(occurrences(sample_page(), "<th scope=\"row\""), 9);
  EXPECT_EQ(nameless("<thead><th>a</th><svg><svg role=\"img\" aria-label=\"\"><title>gnuplot_plot_1</title>"), 4)
      << "control";
}

/// Contrast of two colours "#rrggbb" by WCAG 2: 1 to 21.
double contrast(const std::string& a, const std::string& b) {
  const auto luminance = [](const std::string& colour) {
    double sum = 0.0;
    for (const auto& [at, share] : {std::pair{1, 0.2126}, {3, 0.7152}, {5, 0.0722}}) {
      const double c = std::stoi(colour.substr(static_cast<std::size_t>(at), 2), nullptr, 16) / 255.0;
      sum += share * (c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
    }
    return sum;
  };
  const auto [low, high] = std::minmax({luminance(a), luminance(b)});
  return (high + 0.05) / (low + 0.05);
}

/// The colours of the style sheet by name: of light pages, and of dark ones.
std::array<std::map<std::string, std::string>, 2> page_colours() {
  const std::string page = html_page("", "");
  const auto dark_from = page.find("prefers-color-scheme: dark");
  std::array<std::map<std::string, std::string>, 2> colours;
  static const std::regex kColour(R"(--([a-z]+): (#[0-9a-f]{6});)");
  for (std::sregex_iterator found(page.begin(), page.end(), kColour), end; found != end; ++found) {
    const bool dark = static_cast<std::size_t>(found->position()) > dark_from;
    for (std::size_t scheme = dark ? 1 : 0; scheme < 2; ++scheme) colours[scheme][(*found)[1]] = (*found)[2];
  }
  return colours;
}

TEST(Page, TextHasEnoughContrastInLightAndDark) {
  constexpr double kReadable = 4.5;  // WCAG 2, level AA
  EXPECT_NEAR(contrast("#000000", "#ffffff"), 21.0, 1e-9);
  EXPECT_LT(contrast("#777777", "#ffffff"), kReadable) << "control";
  for (const auto& colours : page_colours()) {
    for (const char* text : {"text", "soft", "accent", "warn", "good"})
      for (const char* ground : {"ground", "card"})
        EXPECT_GE(contrast(colours.at(text), colours.at(ground)), kReadable) << text << " on " << ground;
    for (const auto& [text, ground] : {std::pair{"warn", "outside"}, {"soft", "outside"}, {"text", "alarm"}})
      EXPECT_GE(contrast(colours.at(text), colours.at(ground)), kReadable) << text << " on " << ground;
  }
}

/// The commands that draw one panel.
std::string script_of(Panel panel) {
  const auto directory = std::filesystem::temp_directory_path() / ("nlo-script-" + std::to_string(getpid()));
  std::filesystem::create_directory(directory);
  bool written = true;
  std::string script = figure_script({"", 400, 200, false, {std::move(panel)}}, 0, directory, written);
  std::filesystem::remove_all(directory);
  EXPECT_TRUE(written);
  return script;
}

TEST(Figure, HasTenColoursThatAreSeenOnLightAndDark) {
  constexpr double kVisible = 3.0;  // WCAG 2, of graphics
  Panel panel;
  for (int i = 0; i < 11; ++i)
    panel.series.push_back({"", Series::Style::kLine, i, Eigen::Vector2d(0, 1), Eigen::Vector2d(0, 1), {}});
  const std::string script = script_of(panel);
  std::vector<std::string> drawn;
  static const std::regex kLine(R"(lines lw 1.8 lc rgb '(#[0-9a-f]{6})')");
  for (std::sregex_iterator found(script.begin(), script.end(), kLine), end; found != end; ++found)
    drawn.push_back((*found)[1]);
  ASSERT_EQ(drawn.size(), 11U);
  EXPECT_EQ(std::set<std::string>(drawn.begin(), drawn.end()).size(), 10U);
  for (const std::string& colour : drawn)
    for (const auto& colours : page_colours()) EXPECT_GE(contrast(colour, colours.at("ground")), kVisible) << colour;
}

TEST(Figure, HasNumbersOnALogarithmicAxisWithoutAPowerOfTen) {
  Panel panel;
  panel.log_x = true;
  for (const auto& [low, high, tics] : {std::tuple{1700.0, 6800.0, "(2000, 5000)"},
                                        {300.0, 480.0, "(300, 400)"},
                                        {0.02, 0.3, "(0.02, 0.05, 0.1, 0.2)"},
                                        {0.01, 1000.0, "autofreq"},
                                        {0.0, 0.0, "autofreq"}}) {
    panel.x_low = low;
    panel.x_high = high;
    EXPECT_THAT(script_of(panel), HasSubstr(std::string("set xtics ") + tics + "\n")) << low;
  }
}

TEST(Figure, MakesRoomForLongNumbersLeftOfItsAxis) {
  Panel panel;
  panel.y_high = 1.0;
  EXPECT_THAT(script_of(panel), HasSubstr("set lmargin 9\n"));
  panel.y_low = 0.1219;
  panel.y_high = 0.1224;
  EXPECT_THAT(script_of(panel), HasSubstr("set lmargin 11\n"));
}

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
