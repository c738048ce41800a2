// SPDX-License-Identifier: MIT
#include "trainer/learn/uncertainty/calibration.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(WeightedQuantile, IsTheOrderStatisticOfEqualWeights) {
  VectorXd values(10);
  values << 5, 1, 9, 3, 7, 2, 10, 4, 8, 6;
  const VectorXd ones = VectorXd::Ones(10);
  for (int p = 1; p <= 10; ++p) EXPECT_EQ(weighted_quantile(values, ones, p / 10.0), p);
  EXPECT_EQ(weighted_quantile(values, ones, 0.61), 7);
  EXPECT_EQ(weighted_quantile(VectorXd::Constant(1, 3.0), VectorXd::Constant(1, 0.2), 0.95), 3.0);
}

TEST(WeightedQuantile, CountsAWeightOfTwoAsTwoValues) {
  VectorXd values(3), weights(3);
  values << 1, 2, 3;
  weights << 1, 2, 1;
  EXPECT_EQ(weighted_quantile(values, weights, 0.25), 1);
  EXPECT_EQ(weighted_quantile(values, weights, 0.5), 2);
  EXPECT_EQ(weighted_quantile(values, weights, 0.75), 2);
  EXPECT_EQ(weighted_quantile(values, weights, 0.76), 3);
}

constexpr Eigen::Index kDraws = 20000;

/// One state, one hidden value in [-1, 1], errors draw() times sigma = exp(h - 1).
template <class Draw>
ErrorSamples samples_of(const Draw& draw, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  ErrorSamples samples{MatrixXd(1, kDraws), MatrixXd(1, kDraws), VectorXd::Ones(kDraws),
                       std::vector<bool>(kDraws, true)};
  for (Eigen::Index k = 0; k < kDraws; ++k) {
    samples.hidden(0, k) = uniform(random);
    samples.errors(0, k) = draw(random) * std::exp(samples.hidden(0, k) - 1.0);
  }
  return samples;
}

/// Returns an error head whose sigma is the true one times `scale`.
codegen::ErrorHead head_of(double scale) {
  return {(MatrixXd(1, 2) << 1.0, 0.0).finished(),
          VectorXd::Constant(1, std::log(scale) - 1.0),
          VectorXd::Constant(1, -20.0),
          VectorXd::Constant(1, 20.0),
          VectorXd::Ones(1),
          VectorXd::Constant(1, kNormal95)};
}

double share_within(const codegen::ErrorHead& head, const ErrorSamples& samples, double times) {
  const MatrixXd sigma = codegen::deviations(head, samples.hidden, samples.known);
  return static_cast<double>((samples.errors.array().abs() <= times * sigma.array()).count()) / kDraws;
}

// Tolerance: five binomial deviations of a share of 68 % among 20,000 samples, doubled because the factor has an error
// of the same size.
const double kShareTolerance = 5.0 * std::sqrt(2.0 * 0.68 * 0.32 / kDraws);

TEST(Calibration, NormalErrorsGiveTheFactorsOfTheNormalDistribution) {
  std::normal_distribution<double> normal;
  codegen::ErrorHead head = head_of(1.0);
  calibrate(head, {error_scores(head, samples_of([&](auto& random) { return normal(random); }, 1))});
  // Standard deviation of a quantile: sqrt(p (1 - p) / N) / density, .0033 / .486 and .0015 / .117 for |normal|.
  EXPECT_NEAR(head.factor_68(0), 0.99446, 5.0 * 0.0068);
  EXPECT_NEAR(head.factor_95(0), kNormal95, 5.0 * 0.0132);
}

TEST(Calibration, CorrectsASigmaOfAnySizeAndErrorsOfAnyTail) {
  std::student_t_distribution<double> student(2.0);
  const auto draw = [&](auto& random) { return student(random); };
  const ErrorSamples fresh = samples_of(draw, 3);
  for (const double scale : {0.1, 1.0, 7.0}) {
    codegen::ErrorHead head = head_of(scale);
    EXPECT_GT(std::abs(share_within(head, fresh, head.factor_95(0)) - 0.95), kShareTolerance)
        << "control: without calibration the test must fail";
    calibrate(head, {error_scores(head, samples_of(draw, 2))});
    EXPECT_NEAR(share_within(head, fresh, 1.0), 0.68, kShareTolerance);
    EXPECT_NEAR(share_within(head, fresh, head.factor_95(0) / head.factor_68(0)), 0.95, kShareTolerance);
  }
}

TEST(Calibration, CoversTheHardLogsAmongAnyNumberOfEasyOnes) {
  const ErrorScores easy{MatrixXd::Constant(1, 900, 1.0), VectorXd::Ones(900)};
  const ErrorScores hard{MatrixXd::Constant(1, 100, 5.0), VectorXd::Ones(100)};
  codegen::ErrorHead head = head_of(1.0);
  calibrate(head, {easy, easy, easy, hard});
  EXPECT_EQ(head.factor_68(0), 1.0) << "quantile over the logs: three of four are easy";
  EXPECT_EQ(head.factor_95(0), 5.0) << "pooled, 96 % of the errors would be within 1";
}

TEST(Calibration, DetectsASigmaThatIsWrongByATenth) {
  std::normal_distribution<double> normal;
  const ErrorSamples fresh = samples_of([&](auto& random) { return normal(random); }, 4);
  for (const double scale : {0.9, 1.1})
    EXPECT_GT(std::abs(share_within(head_of(scale), fresh, 0.99446) - 0.68), kShareTolerance);
  EXPECT_NEAR(share_within(head_of(1.0), fresh, 0.99446), 0.68, kShareTolerance);
}

}  // namespace
}  // namespace nlo::trainer
