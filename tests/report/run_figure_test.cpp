// SPDX-License-Identifier: MIT
#include "trainer/app/report/run_figure.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>

#include "tests/report/sample_report.h"
#include "trainer/app/report/thinning.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;
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

TEST(RunFigure, MeasuresErrorsOfAnglesTheShortWayRound) {
  // The estimate is wrong by a whole turn plus at most 0.02 rad.
  const Panel error = figure_of(test::sample_logs(1)).panels[1];
  EXPECT_NEAR(largest(error.series.back().y), 0.02, 1e-3);  // peaks fall between samples
}

TEST(RunFigure, ErrorIsEstimateMinusTruth) {
  EXPECT_NEAR(figure_of(test::sample_logs(1)).panels[3].series.back().y[0], 200.0, 1e-9);
}

TEST(RunFigure, ALargeInitialErrorDoesNotSetTheScaleAndIsStated) {
  const Figure whole = figure_of(test::sample_logs(1));
  EXPECT_LT(whole.panels[3].y_high, 100.0);
  EXPECT_THAT(whole.panels[3].series.back().title, HasSubstr("largest 200 (beyond the scale)"));
  EXPECT_THAT(whole.panels[2].series.back().title, HasSubstr("beyond the scale"));
  EXPECT_LT(whole.panels[2].y_high, 10.0);
  // Control: the error of the angle has no such start.
  EXPECT_THAT(whole.panels[1].series.back().title, Not(HasSubstr("beyond")));
  EXPECT_GT(whole.panels[1].y_high, largest(whole.panels[1].series.back().y));
}

TEST(RunFigure, ShadesMaskedSamplesAndSamplesOutsideOfTheDomain) {
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

TEST(RunFigure, ShadesASingleSampleWideEnoughToBeVisible) {
  LogEvaluation logs = test::sample_logs(1);
  logs.examples[0].outside.setZero();
  logs.examples[0].outside[700] = 1.0;
  const std::vector<Band> bands = figure_of(logs).panels[0].bands;
  ASSERT_EQ(bands.size(), 2U);
  EXPECT_GE(bands[1].to - bands[1].from, (14.99 / 960.0));  // a pixel of the figure
}

TEST(RunFigure, ARunOfOneSampleHasNoPanels) {
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

TEST(RunFigure, NamesOutputsThatAreNotStatesAndKeepsTheirPeaks) {
  LogEvaluation logs = test::sample_logs(1);
  EvaluatedRun& run = logs.examples[0];
  run.truth.outputs.row(0).setZero();  // no output is a state any more
  run.measured.setZero();
  run.measured(0, 701) = 4.0;  // one sample of hundreds
  const Figure figure = figure_of(logs);
  ASSERT_EQ(figure.panels.size(), 5U);
  EXPECT_EQ(figure.panels[4].series[0].title, "angle, measured [rad]");
  EXPECT_GT(largest(figure.panels[4].series[0].y), 2.0);
}

TEST(RunFigure, DrawsInputsByNameIfTheRunHasThem) {
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

TEST(RunFigure, ExplainsTheShadingOnce) {
  std::vector<std::string> said;
  for (const Panel& panel : figure_of(test::sample_logs(1)).panels)
    for (const Band& band : panel.bands)
      if (!band.title.empty()) said.push_back(band.title);
  EXPECT_THAT(said, testing::ElementsAre("not scored", "outside of the training domain"));
}

TEST(RunPicture, HasOnlyStatesAndErrorsAndNamesTheRun) {
  LogEvaluation logs = test::sample_logs(1);
  EvaluatedRun& run = logs.examples[0];
  run.truth.outputs.row(0).setZero();  // no output is a state any more; control: the test above
  const auto label = [&] { return run_picture(run, logs.states, logs.outputs).panels.back().x_label; };
  EXPECT_EQ(run_picture(run, logs.states, logs.outputs).panels.size(), 4U);
  EXPECT_THAT(label(), HasSubstr(run.truth.source + ": RMSE " + run_errors(run, logs.states)));
  EXPECT_THAT(label(), Not(HasSubstr("domain")));
  run.outside.setZero();
  EXPECT_THAT(label(), HasSubstr("; all in the training domain"));
}

/// Scale of the plot in which lines are drawn [pixels]; x runs from 0 to 1, y from -1 to 1.
constexpr PixelScale kPlot{860.0, 60.0};

double distance_to_segment(Eigen::Vector2d p, Eigen::Vector2d a, Eigen::Vector2d b) {
  const Eigen::Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double part = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - a - part * along).norm();
}

/// Returns the largest distance of the points (x, y) from the line [pixels]; neither may have gaps.
double farthest(const VectorXd& x, const VectorXd& y, const Line& line) {
  const auto pixel = [](double px, double py) { return Eigen::Vector2d(px * kPlot.x, py * kPlot.y); };
  double most = 0.0;
  for (Index k = 0; k < x.size(); ++k) {
    double least = 1e9;
    // Segments that are three pixels or more to the side are not nearer than that.
    const auto begin = std::lower_bound(line.x.begin(), line.x.end(), x[k] - 3.0 / kPlot.x) - line.x.begin();
    for (Index i = std::max<Index>(begin, 1); i < line.x.size(); ++i) {
      if (line.x[i - 1] > x[k] + 3.0 / kPlot.x) break;
      least = std::min(least, distance_to_segment(pixel(x[k], y[k]), pixel(line.x[i - 1], line.y[i - 1]),
                                                  pixel(line.x[i], line.y[i])));
    }
    most = std::max(most, least);
  }
  return most;
}

/// A slow wave with noise and rare spikes, at uneven steps.
std::pair<VectorXd, VectorXd> wild(Index samples, double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  VectorXd x(samples), y(samples);
  for (Index k = 0; k < samples; ++k)
    x[k] = (static_cast<double>(k) + 0.8 * uniform(random)) / static_cast<double>(samples);
  for (Index k = 0; k < samples; ++k) {
    y[k] = 0.6 * std::sin(20.0 * x[k]) + noise * (uniform(random) - 0.5);
    if (uniform(random) < 1e-3) y[k] = 2.0 * uniform(random) - 1.0;
  }
  return {x, y};
}

TEST(ThinnedLine, StaysWithinAPixelOfEveryPointAndDrawsNoOtherPoints) {
  for (const Index samples : {3L, 100L, 1000L, 7000L, 40'000L}) {
    for (const double noise : {0.0, 0.01, 0.3}) {
      SCOPED_TRACE(testing::Message() << samples << " samples, noise " << noise);
      const auto [x, y] = wild(samples, noise, 7);
      const Line line = thinned_line(x, y, kPlot);
      EXPECT_LT(farthest(x, y, line), 1.0);
      EXPECT_EQ(line.y.maxCoeff(), y.maxCoeff());
      EXPECT_EQ(line.y.minCoeff(), y.minCoeff());
      std::set<std::pair<double, double>> points;
      for (Index k = 0; k < samples; ++k) points.emplace(x[k], y[k]);
      for (Index k = 0; k < line.x.size(); ++k) EXPECT_TRUE(points.contains({line.x[k], line.y[k]}));
      for (Index k = 1; k < line.x.size(); ++k) ASSERT_GT(line.x[k], line.x[k - 1]);
    }
  }
}

TEST(ThinnedLine, TheDistanceDetectsALineThatLosesPeaks) {  // the control of the test above
  const auto [x, y] = wild(7000, 0.01, 7);
  Line sparse;
  sparse.x = x(Eigen::seqN(0, 700, 10));
  sparse.y = y(Eigen::seqN(0, 700, 10));
  EXPECT_GT(farthest(x, y, sparse), 5.0);
}

TEST(ThinnedLine, HasAboutAsManyPointsForAnyLengthOfTheLog) {
  const auto [x, smooth] = wild(100'000, 0.0, 1);
  EXPECT_LT(thinned_line(x, smooth, kPlot).x.size(), 1000);  // points for a hundred spikes and a few waves
  const auto [t, noisy] = wild(100'000, 0.3, 1);
  EXPECT_LE(thinned_line(t, noisy, kPlot).x.size(), 2 * 2 * 860 + 2);
}

TEST(ThinnedLine, KeepsEveryPeakAndEveryGap) {
  const VectorXd x = VectorXd::LinSpaced(100'000, 0.0, 1.0);
  VectorXd y = (30.0 * x.array()).sin();
  y[54'321] = 1650.0;
  y[77'777] = -9.0;
  y.segment(12'345, 3).setConstant(std::nan(""));
  const Line line = thinned_line(x, y, kPlot);
  EXPECT_LT(line.x.size(), 1000);
  EXPECT_EQ(line.y.maxCoeff<Eigen::PropagateNumbers>(), 1650.0);
  EXPECT_EQ(line.y.minCoeff<Eigen::PropagateNumbers>(), -9.0);
  EXPECT_EQ(line.y.array().isNaN().count(), 1);
}

TEST(ThinnedLine, AcceptsLinesOfOnePointOrWithoutExtent) {
  EXPECT_EQ(thinned_line(VectorXd(), VectorXd(), kPlot).y.size(), 0);
  EXPECT_EQ(thinned_line(VectorXd::Zero(1), VectorXd::Ones(1), kPlot).y.size(), 1);
  EXPECT_EQ(thinned_line(VectorXd::LinSpaced(500, 0.0, 1.0), VectorXd::Ones(500), kPlot).y.size(), 2);
  EXPECT_EQ(thinned_line(VectorXd::LinSpaced(500, 0.0, 1.0), VectorXd::Constant(500, std::nan("")), kPlot).y.size(), 1);
}

}  // namespace
}  // namespace nlo::trainer
