// SPDX-License-Identifier: MIT
#include "trainer/report/run_figure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/report/sample_report.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;
using testing::Not;

Figure figure_of(const LogEvaluation& logs, double t0 = 0.0, double t1 = 1e9) {
  return run_figure(logs.examples.front(), logs.states, logs.outputs, t0, t1);
}

double largest(const Eigen::VectorXd& values) {
  return values.cwiseAbs().maxCoeff<Eigen::PropagateNumbers>();
}

TEST(RunFigure, HasTheErrorUnderEachStateOnTheSameTimeAxis) {
  const Figure figure = figure_of(test::sample_logs(1));
  ASSERT_EQ(figure.panels.size(), 4U);  // two states, each with its error; the output is a state
  for (const Panel& panel : figure.panels) {
    EXPECT_EQ(panel.x_low, figure.panels[0].x_low);
    EXPECT_EQ(panel.x_high, figure.panels[0].x_high);
  }
  EXPECT_EQ(figure.panels[0].y_label, "angle [rad]");
  EXPECT_EQ(figure.panels[1].y_label, "error [rad]");
  EXPECT_EQ(figure.panels[3].y_label, "error [rad/s]");
}

TEST(RunFigure, TakesErrorsOfAnglesTheShortWayRound) {
  // The estimate is a whole turn and at most 0.02 rad off.
  const Panel error = figure_of(test::sample_logs(1)).panels[1];
  EXPECT_NEAR(largest(error.series.back().y), 0.02, 1e-3);  // peaks fall between samples
}

TEST(RunFigure, ErrorIsEstimateMinusTruth) {
  EXPECT_NEAR(figure_of(test::sample_logs(1)).panels[3].series.back().y[0], 200.0, 1e-9);
}

TEST(RunFigure, AWildStartDoesNotSetTheScaleAndIsSaid) {
  const Figure whole = figure_of(test::sample_logs(1));
  EXPECT_LT(whole.panels[3].y_high, 100.0);
  EXPECT_THAT(whole.panels[3].series.back().title, HasSubstr("largest 200 (beyond the scale)"));
  EXPECT_THAT(whole.panels[2].series.back().title, HasSubstr("beyond the scale"));
  EXPECT_LT(whole.panels[2].y_high, 10.0);
  // Control: the angle's error has no such start.
  EXPECT_THAT(whole.panels[1].series.back().title, Not(HasSubstr("beyond")));
  EXPECT_GT(whole.panels[1].y_high, largest(whole.panels[1].series.back().y));
}

TEST(RunFigure, ShadesWhatIsMaskedAndWhatIsOutsideOfTheDomain) {
  const LogEvaluation logs = test::sample_logs(1);
  for (const Panel& panel : figure_of(logs).panels) {
    ASSERT_EQ(panel.bands.size(), 2U);
    EXPECT_NEAR(panel.bands[0].from, 13.495, 1e-6);  // half a step before the first masked sample
    EXPECT_NEAR(panel.bands[0].to, 14.99, 1e-2 + 0.02);
    EXPECT_NEAR(panel.bands[1].from, 0.0, 1e-9);
    EXPECT_NEAR(panel.bands[1].to, 0.295, 1e-6);
    EXPECT_NE(panel.bands[0].colour, panel.bands[1].colour);
  }
  EXPECT_TRUE(figure_of(logs, 1.0, 12.0).panels[0].bands.empty());
}

TEST(RunFigure, OneSampleOutsideIsWideEnoughToBeSeen) {
  LogEvaluation logs = test::sample_logs(1);
  logs.examples[0].outside.setZero();
  logs.examples[0].outside[700] = 1.0;
  const std::vector<Band> bands = figure_of(logs).panels[0].bands;
  ASSERT_EQ(bands.size(), 2U);
  EXPECT_GE(bands[1].to - bands[1].from, (14.99 / 960.0));  // a pixel of the figure
}

TEST(RunFigure, TooShortARunHasNoPanels) {
  EXPECT_TRUE(figure_of(test::sample_logs(1), 3.001, 3.002).panels.empty());
}

TEST(RunErrors, AreRootMeanSquaresOfScoredSamplesWithUnits) {
  LogEvaluation logs = test::sample_logs(1);
  EvaluatedRun& run = logs.examples[0];
  run.estimate = run.truth.states;
  run.estimate.row(1).array() += 0.25;
  run.estimate(1, run.truth.samples() - 1) = 1e6;  // masked
  EXPECT_EQ(run_errors(run, logs.states), "angle 0 rad, rate 0.250 rad/s");
}

TEST(RunFigure, NamesOutputsThatAreNoStatesAndKeepsTheirPeaks) {
  LogEvaluation logs = test::sample_logs(1);
  EvaluatedRun& run = logs.examples[0];
  run.truth.outputs.row(0).setZero();  // no state any more
  run.measured.setZero();
  run.measured(0, 701) = 4.0;  // one sample of hundreds
  const Figure figure = figure_of(logs);
  ASSERT_EQ(figure.panels.size(), 5U);
  EXPECT_EQ(figure.panels[4].series[0].title, "angle, measured [rad]");
  EXPECT_GT(largest(figure.panels[4].series[0].y), 2.0);
}

TEST(RunFigure, DrawsInputsByNameWhereTheRunHasThem) {
  LogEvaluation logs = test::sample_logs(1);
  EvaluatedRun& run = logs.examples[0];
  run.truth.inputs = run.truth.time_s.transpose().array().sin();
  const auto figure = [&](const std::vector<Channel>& inputs) {
    return run_figure(run, logs.states, logs.outputs, 0.0, 1e9, inputs);
  };
  const Figure drawn = figure({{"motor", "V", 0.0}});
  ASSERT_EQ(drawn.panels.size(), 5U);
  EXPECT_EQ(drawn.panels[4].series[0].title, "motor, input [V]");
  EXPECT_GT(largest(drawn.panels[4].series[0].y), 0.99);
  EXPECT_EQ(drawn.panels[4].x_label, "time [s]");
  EXPECT_EQ(figure({}).panels.size(), 4U);
}

TEST(RunFigure, TruthIsBroaderThanTheEstimateThatIsDrawnOverIt) {
  const Panel state = figure_of(test::sample_logs(1)).panels[0];
  const std::size_t last = state.series.size() - 1;
  EXPECT_EQ(state.series[last - 1].title, "truth");
  EXPECT_EQ(state.series[last - 1].style, Series::Style::kBroadLine);
  EXPECT_EQ(state.series[last].style, Series::Style::kLine);
}

TEST(RunFigure, SaysOnceWhatIsShaded) {
  std::vector<std::string> said;
  for (const Panel& panel : figure_of(test::sample_logs(1)).panels)
    for (const Band& band : panel.bands)
      if (!band.title.empty()) said.push_back(band.title);
  EXPECT_THAT(said, testing::ElementsAre("not scored", "outside of the training domain"));
}

TEST(RunPicture, HasStatesAndErrorsAloneAndNamesTheRun) {
  LogEvaluation logs = test::sample_logs(1);
  EvaluatedRun& run = logs.examples[0];
  run.truth.outputs.row(0).setZero();  // no state any more: the control is the test above
  const auto label = [&] { return run_picture(run, logs.states, logs.outputs).panels.back().x_label; };
  EXPECT_EQ(run_picture(run, logs.states, logs.outputs).panels.size(), 4U);
  EXPECT_THAT(label(), HasSubstr(run.truth.source + ": RMSE " + run_errors(run, logs.states)));
  EXPECT_THAT(label(), Not(HasSubstr("domain")));
  run.outside.setZero();
  EXPECT_THAT(label(), HasSubstr("; all in the training domain"));
}

}  // namespace
}  // namespace nlo::trainer
