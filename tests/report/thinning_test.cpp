// SPDX-License-Identifier: MIT
#include "trainer/report/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <utility>

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// The plot that lines are drawn in [pixels]; their x and y go from 0 to 1 and from -1 to 1.
constexpr PixelScale kPlot{860.0, 60.0};

double distance_to_segment(Eigen::Vector2d p, Eigen::Vector2d a, Eigen::Vector2d b) {
  const Eigen::Vector2d along = b - a;
  const double length = along.squaredNorm();
  const double part = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
  return (p - a - part * along).norm();
}

/// Largest distance of a point of (x, y) from the line [pixels]; both without gaps.
double farthest(const VectorXd& x, const VectorXd& y, const Line& line) {
  const auto pixel = [](double px, double py) { return Eigen::Vector2d(px * kPlot.x, py * kPlot.y); };
  double most = 0.0;
  for (Index k = 0; k < x.size(); ++k) {
    double least = 1e9;
    // Segments three pixels and more to the side are no nearer than that.
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

/// A slow wave with noise and rare spikes; uneven steps.
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

TEST(ThinnedLine, NoPointIsAPixelFromWhatIsDrawnAndNothingElseIsDrawn) {
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

TEST(ThinnedLine, TheDistanceSeesALineThatLosesPeaks) {  // the control of the test above
  const auto [x, y] = wild(7000, 0.01, 7);
  Line sparse;
  sparse.x = x(Eigen::seqN(0, 700, 10));
  sparse.y = y(Eigen::seqN(0, 700, 10));
  EXPECT_GT(farthest(x, y, sparse), 5.0);
}

TEST(ThinnedLine, WeighsWhatThePictureWeighsHoweverLongTheLog) {
  const auto [x, smooth] = wild(100'000, 0.0, 1);
  EXPECT_LT(thinned_line(x, smooth, kPlot).x.size(), 1000);  // a hundred spikes and some waves
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

TEST(ThinnedLine, TakesLinesOfNoExtent) {
  EXPECT_EQ(thinned_line(VectorXd(), VectorXd(), kPlot).y.size(), 0);
  EXPECT_EQ(thinned_line(VectorXd::Zero(1), VectorXd::Ones(1), kPlot).y.size(), 1);
  EXPECT_EQ(thinned_line(VectorXd::LinSpaced(500, 0.0, 1.0), VectorXd::Ones(500), kPlot).y.size(), 2);
  EXPECT_EQ(thinned_line(VectorXd::LinSpaced(500, 0.0, 1.0), VectorXd::Constant(500, std::nan("")), kPlot).y.size(), 1);
}

}  // namespace
}  // namespace nlo::trainer
