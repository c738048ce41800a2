// SPDX-License-Identifier: MIT
#include "trainer/base/ridge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>
#include <vector>

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kRuns = 40, kLength = 400;

/// Runs of one feature u and one state x = slope(k) u + sigma(k) n at sample k, with n normal.
struct Runs {
  MatrixXd u{1, kRuns*kLength}, x{1, kRuns*kLength};
  std::vector<int> since_start;

  template <class Slope, class Sigma>
  Runs(const Slope& slope, const Sigma& sigma) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (Index k = 0; k < u.cols(); ++k) {
      const int time = static_cast<int>(k % kLength);
      since_start.push_back(time);
      u(0, k) = normal(random);
      x(0, k) = slope(time) * u(0, k) + sigma(time) * normal(random);
    }
  }

  MatrixXd fit(const MatrixXd& features) const {
    TransientRidge ridge;
    ridge.add(features, x, VectorXd::Ones(x.cols()), since_start);
    return ridge.fit(1e-9);
  }
  MatrixXd plain_fit(const MatrixXd& features) const {
    Ridge ridge;
    ridge.add(features, x, VectorXd::Ones(x.cols()));
    return ridge.fit(1e-9);
  }
};

double clock_at(int time) {
  return std::exp(-time / 20.0);
}

TEST(Ridge, MeanSquaredErrorIsThatOfTheSamples) {
  const Runs runs([](int) { return 2.0; }, [](int) { return 0.5; });
  Ridge ridge;
  ridge.add(runs.u, runs.x, VectorXd::Ones(runs.x.cols()));
  const MatrixXd w = (MatrixXd(1, 2) << 0.3, 1.5).finished();
  const double expected = (w * with_one(runs.u) - runs.x).squaredNorm() / static_cast<double>(runs.x.cols());
  EXPECT_NEAR(ridge.squared_errors(w)(0), expected, 1e-9 * expected);  // sums of 16,000 terms
  EXPECT_NEAR(ridge.mean()(0), runs.x.mean(), 1e-12);
}

TEST(Ridge, SharesOfTwoSetsActAsWeights) {
  const Runs one([](int) { return 2.0; }, [](int) { return 0.5; }),
      other([](int) { return -1.0; }, [](int) { return 0.1; });
  Ridge first, second, together, weighted;
  first.add(one.u, one.x, VectorXd::Ones(one.x.cols()));
  second.add(other.u, other.x, VectorXd::Ones(other.x.cols()));
  together.add(first, 1.0);
  together.add(second, 3.0);
  weighted.add(one.u, one.x, VectorXd::Ones(one.x.cols()));
  weighted.add(other.u, other.x, VectorXd::Constant(other.x.cols(), 3.0));
  EXPECT_LT((together.fit(1e-6) - weighted.fit(1e-6)).norm(), 1e-12);
}

TEST(TransientRidge, FindsBothTheTransientAndTheSettledMap) {
  // x = (1 + 4 c) u: the map of [u; u c] is exact at every time.
  const Runs runs([](int time) { return 1.0 + 4.0 * clock_at(time); }, [](int) { return 0.0; });
  MatrixXd features(2, runs.u.cols());
  features.row(0) = runs.u;
  for (Index k = 0; k < runs.u.cols(); ++k)
    features(1, k) = runs.u(0, k) * clock_at(runs.since_start[static_cast<std::size_t>(k)]);
  const MatrixXd w = runs.fit(features);
  EXPECT_NEAR(w(0, 1), 1.0, 1e-6);  // the ridge of 1e-9
  EXPECT_NEAR(w(0, 2), 4.0, 1e-6);
}

TEST(TransientRidge, LargeEarlyErrorsDoNotChangeTheSettledMap) {
  // The slope is 5 while c is more than a half, and then 1: one slope cannot be both.
  const Runs runs([](int time) { return time < 14 ? 5.0 : 1.0; }, [](int time) { return time < 14 ? 20.0 : 0.01; });
  const double settled_error = std::abs(runs.fit(runs.u)(0, 1) - 1.0);
  EXPECT_LT(settled_error, 0.005);                               // a hundredth of the error of the plain fit
  EXPECT_GT(std::abs(runs.plain_fit(runs.u)(0, 1) - 1.0), 0.1);  // control: early samples pull the plain fit
}

TEST(TransientRidge, EqualsThePlainFitIfErrorsAreTheSameAtAllTimes) {
  const Runs runs([](int) { return 2.0; }, [](int) { return 0.5; });
  // Each octave of time has the same weight, not each sample. Fewer samples then count, so the slope agrees only within
  // their noise.
  EXPECT_NEAR(runs.fit(runs.u)(0, 1), runs.plain_fit(runs.u)(0, 1), 0.03);
}

TEST(TransientRidge, GivesTheSameMapForSamplesInAnyBlocks) {
  const Runs runs([](int time) { return 1.0 + clock_at(time); }, [](int time) { return 0.1 + clock_at(time); });
  TransientRidge ridge;
  for (Index from = 0; from < runs.u.cols(); from += 1000) {
    const std::vector<int> times(runs.since_start.begin() + from, runs.since_start.begin() + from + 1000);
    ridge.add(runs.u.middleCols(from, 1000), runs.x.middleCols(from, 1000), VectorXd::Ones(1000), times);
  }
  EXPECT_LT((ridge.fit(1e-9) - runs.fit(runs.u)).norm(), 1e-10);
}

}  // namespace
}  // namespace nlo::trainer
