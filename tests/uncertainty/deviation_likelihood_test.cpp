// SPDX-License-Identifier: MIT
#include "trainer/learn/uncertainty/deviation_likelihood.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Problem {
  MatrixXd features;
  VectorXd squares, weights;
};

/// Normal errors whose log deviation is `truth` (n + 1) in uniform features.
Problem normal_errors(const VectorXd& truth, Eigen::Index count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::normal_distribution<double> normal;
  const Eigen::Index n = truth.size() - 1;
  Problem p{MatrixXd(n, count), VectorXd(count), VectorXd(count)};
  for (Eigen::Index k = 0; k < count; ++k) {
    for (Eigen::Index i = 0; i < n; ++i) p.features(i, k) = uniform(random);
    const double s = truth.head(n).dot(p.features.col(k)) + truth(n);
    p.squares(k) = std::pow(normal(random) * std::exp(s), 2) + 1e-12;
    p.weights(k) = 0.5 + 0.5 * std::abs(uniform(random));
  }
  return p;
}

TEST(DeviationLikelihood, DerivativesAgreeWithCentralDifferences) {
  const Problem p = normal_errors(VectorXd::LinSpaced(5, -0.6, 0.8), 300, 1);
  const VectorXd at = VectorXd::LinSpaced(5, 0.3, -0.4);
  constexpr double kRidge = 0.1, kStep = 1e-5;
  const DeviationLikelihood l = deviation_likelihood(p.features, p.squares, p.weights, at, kRidge);
  EXPECT_DOUBLE_EQ(l.value, deviation_cost(p.features, p.squares, p.weights, at, kRidge));
  // The cost is of order 1: truncation step^2 = 1e-10 times its third derivative (< 10), rounding 1e-16 / step = 1e-11.
  constexpr double kTolerance = 1e-8;
  for (Eigen::Index i = 0; i < at.size(); ++i) {
    VectorXd up = at, down = at;
    up(i) += kStep;
    down(i) -= kStep;
    const auto above = deviation_likelihood(p.features, p.squares, p.weights, up, kRidge);
    const auto below = deviation_likelihood(p.features, p.squares, p.weights, down, kRidge);
    EXPECT_NEAR(l.gradient(i), (above.value - below.value) / (2.0 * kStep), kTolerance);
    for (Eigen::Index j = 0; j < at.size(); ++j)
      EXPECT_NEAR(l.hessian(i, j), (above.gradient(j) - below.gradient(j)) / (2.0 * kStep), kTolerance);
  }
}

TEST(DeviationLikelihood, HasItsMinimumAtTheLogDeviationOfTheErrors) {
  const VectorXd truth = VectorXd::LinSpaced(4, -1.2, 0.9);
  constexpr Eigen::Index kErrors = 40000;
  const Problem p = normal_errors(truth, kErrors, 2);
  const VectorXd found = most_likely_deviation(p.features, p.squares, p.weights, 0.0);
  // Standard deviation of a fitted weight: Fisher information 2 per sample and unit of s, variance of a feature 1/3,
  // weights of samples within a factor of 2.
  const double deviation = std::sqrt(3.0 / 2.0 / kErrors);
  for (Eigen::Index i = 0; i < truth.size(); ++i) EXPECT_NEAR(found(i), truth(i), 5.0 * deviation);
  const auto l = deviation_likelihood(p.features, p.squares, p.weights, found, 0.0);
  EXPECT_LT(l.gradient.lpNorm<Eigen::Infinity>(), 1e-5);
}

TEST(DeviationLikelihood, WithoutFeaturesIsTheRootMeanSquare) {
  Problem p = normal_errors(VectorXd::Constant(2, -0.3), 500, 3);
  p.features.setZero();
  const VectorXd found = most_likely_deviation(p.features, p.squares, p.weights, 1e-4);
  EXPECT_NEAR(std::exp(2.0 * found(1)), p.weights.dot(p.squares) / p.weights.sum(), 1e-12);
  EXPECT_EQ(found(0), 0.0);
}

TEST(DeviationLikelihood, ConvergesForErrorsOfAnyMagnitude) {
  for (const double scale : {1e-6, 1.0, 1e6}) {
    Problem p = normal_errors(VectorXd::LinSpaced(3, -2.0, 2.0), 5000, 4);
    p.squares *= scale * scale;
    p.squares(0) *= 1e6;  // an outlier of a thousand sigmas
    const VectorXd found = most_likely_deviation(p.features, p.squares, p.weights, 1e-4);
    const auto l = deviation_likelihood(p.features, p.squares, p.weights, found, 1e-4);
    EXPECT_LT(l.gradient.lpNorm<Eigen::Infinity>(), 1e-5) << scale;
  }
}

}  // namespace
}  // namespace nlo::trainer
