// SPDX-License-Identifier: MIT
// The error head against closed forms: a linear plant, a linear latent system and a linear T* leave an error that is
// normal, with a covariance that a Lyapunov equation gives.
#include "trainer/learn/uncertainty/error_head_fit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "codegen/model/latent_step.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/learn/uncertainty/calibration.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kPeriod = 0.05, kSigma = 0.3;

/// exp(A h) of the harmonic oscillator x1' = x2, x2' = -x1.
Matrix2d transition() {
  const double c = std::cos(kPeriod), s = std::sin(kPeriod);
  return (Matrix2d() << c, s, -s, c).finished();
}

/// Two real modes and T* = M^-1, with M the steady map from x to z: M exp(A h) = A_z M + B0 C + B1 C exp(A h). The
/// network also has four hidden neurons that T* does not read.
codegen::Model linear_observer() {
  codegen::Model m;
  m.name = "linear";
  m.outputs = {{"y", "", 0.0}};
  m.states = {{"x1", "", 0.0}, {"x2", "", 0.0}};
  m.sample_period_s = kPeriod;
  m.initial_latent = Vector2d::Zero();
  m.output_min = VectorXd::Constant(1, -20.0);
  m.output_max = VectorXd::Constant(1, 20.0);
  m.latent_min = VectorXd::Constant(2, -20.0);
  m.latent_max = VectorXd::Constant(2, 20.0);
  codegen::Kkl& own = m.structure.emplace<codegen::Kkl>();
  own.latent.eigenvalues = Vector2d(-0.8, -2.0);
  own.latent.output_injection = Vector2d(1.0, 2.0);
  const codegen::StepMatrices step = codegen::latent_step(m, kPeriod);
  const Matrix2d e = transition();
  MatrixXd map(2, 2);
  for (int i = 0; i < 2; ++i) {
    const Eigen::RowVector2d c(1.0, 0.0), driven = step.b0(i, 0) * c + step.b1(i, 0) * c * e;
    map.row(i) = driven * (e - (1.0 + step.a_minus_1(i)) * Matrix2d::Identity()).inverse();
  }
  codegen::Network& n = own.inverse_map;
  n.features = MatrixXd::Identity(2, 3);
  n.feature_mean = n.output_mean = VectorXd::Zero(2);
  n.feature_scale = n.output_scale = VectorXd::Ones(2);
  n.skip = map.inverse();
  n.layers = {{MatrixXd::Random(4, 2), VectorXd::LinSpaced(4, -0.5, 0.5)}, {MatrixXd::Zero(2, 4), VectorXd::Zero(2)}};
  return m;
}

/// Standard deviation of x_hat - x after the transient: that of T P T', with the covariance P of z driven by white
/// noise through z+ = A z + B0 v_k + B1 v_k+1.
Vector2d true_deviation(const codegen::Model& m) {
  const codegen::StepMatrices step = codegen::latent_step(m, kPeriod);
  Matrix2d p;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      const double a = 1.0 + step.a_minus_1(i), b = 1.0 + step.a_minus_1(j);
      const double gi = a * step.b1(i, 0) + step.b0(i, 0), gj = b * step.b1(j, 0) + step.b0(j, 0);
      p(i, j) = kSigma * kSigma * (gi * gj / (1.0 - a * b) + step.b1(i, 0) * step.b1(j, 0));
    }
  const MatrixXd& t = codegen::inverse_map(m)->skip;
  return (t * p * t.transpose()).diagonal().cwiseSqrt();
}

/// Errors of the observer on noisy runs, from settled_s on.
ErrorSamples run_observer(const codegen::Model& m, double settled_s, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  constexpr Index kSamples = 1500;
  codegen::ReferenceObserver<double> observer(m);
  ErrorSamples all;
  for (int run = 0; run < 40; ++run) {
    MatrixXd x(2, kSamples), y(1, kSamples);
    x.col(0) << normal(random), normal(random);
    for (Index k = 0; k < kSamples; ++k) {
      if (k > 0) x.col(k) = transition() * x.col(k - 1);
      y(0, k) = x(0, k) + kSigma * normal(random);
    }
    const codegen::Run answer = observer.run(y, {}, VectorXd::LinSpaced(kSamples, 0.0, kPeriod * (kSamples - 1)), true);
    const auto first = static_cast<Index>(settled_s / kPeriod);
    const Index n = kSamples - first;
    all.append({observer.last_hidden(answer.z.rightCols(n), answer.y.rightCols(n)), (answer.x_hat - x).rightCols(n),
                VectorXd::Ones(n), std::vector<bool>(static_cast<std::size_t>(n), true)});
  }
  return all;
}

TEST(ErrorHead, GivesTheDeviationOfTheLyapunovEquationForALinearPlant) {
  const codegen::Model m = linear_observer();
  const Vector2d truth = true_deviation(m);
  const ErrorSamples samples = run_observer(m, 15.0, 1);
  codegen::ErrorHead head = fit_error_head(samples, samples);
  calibrate(head, {error_scores(head, run_observer(m, 15.0, 2))});
  const MatrixXd sigma = codegen::deviations(head, samples.hidden, samples.known);
  // The 48,000 errors are correlated over about 25 samples of the slow mode, so they count as 2,000 independent ones,
  // from which a deviation is known to 1 / sqrt(2 * 2000) = 1.6 %. The single sigma also varies with the noise of the
  // features, by a few times as much.
  constexpr double kMean = 0.05, kEach = 0.15;
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(sigma.row(i).mean() / truth(i), 0.99446, kMean) << i;
    EXPECT_LT(sigma.row(i).maxCoeff() / truth(i), 1.0 + 3.0 * kEach) << i;
    const double spread = std::sqrt((sigma.row(i).array() / sigma.row(i).mean() - 1.0).square().mean());
    EXPECT_LT(spread, kEach) << "the true deviation is the same everywhere";
    EXPECT_NEAR(head.factor_95(i) / head.factor_68(i), kNormal95 / 0.99446, 0.1) << i;
  }
}

TEST(ErrorHead, LeavesOutSamplesOutsideOfTheDomain) {
  const codegen::Model m = linear_observer();
  ErrorSamples samples = run_observer(m, 15.0, 1);
  const codegen::ErrorHead before = fit_error_head(samples, samples);
  ErrorSamples corrupted = samples;
  corrupted.errors *= 100.0;
  corrupted.known.assign(corrupted.known.size(), false);
  samples.append(corrupted);
  const codegen::ErrorHead after = fit_error_head(samples, samples);
  EXPECT_LT((after.weights - before.weights).norm(), 1e-6 * (1.0 + before.weights.norm()));
  EXPECT_LT((after.log_max - before.log_max).norm(), 1e-6);
}

TEST(ErrorHead, GivesAMirrorImageTheSameDeviation) {
  // tanh of odd features: the features of a mirror image have the opposite sign, its sigma is the same. A head that
  // reads only h cannot do that.
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-2.0, 2.0);
  std::normal_distribution<double> normal;
  constexpr Index kCount = 20000;
  ErrorSamples samples{MatrixXd(1, kCount), MatrixXd(1, kCount), VectorXd::Ones(kCount),
                       std::vector<bool>(kCount, true)};
  for (Index k = 0; k < kCount; ++k) {
    const double h = std::tanh(uniform(random));
    samples.hidden(0, k) = h;
    samples.errors(0, k) = std::exp(2.0 * h * h - 1.0) * normal(random);
  }
  const codegen::ErrorHead head = fit_error_head(samples, samples);
  const MatrixXd places = (MatrixXd(1, 4) << 0.0, 0.3, -0.9, 0.9).finished();
  const MatrixXd sigma = codegen::deviations(head, places, std::vector<bool>(4, true));
  constexpr double kTolerance = 0.05;  // 1 / sqrt(2 * 20000) of log sigma, times 10 for the ends of the range
  for (Index k = 0; k < 4; ++k)
    EXPECT_NEAR(std::log(sigma(0, k)), 2.0 * places(0, k) * places(0, k) - 1.0, kTolerance) << k;
}

TEST(ErrorHead, IsFiniteForAnExactStateAndForAConstantState) {
  ErrorSamples samples{MatrixXd::Zero(3, 100), MatrixXd::Zero(2, 100), VectorXd::Ones(100),
                       std::vector<bool>(100, true)};
  samples.errors.row(1).setConstant(0.5);
  codegen::ErrorHead head = fit_error_head(samples, samples);
  calibrate(head, {error_scores(head, samples)});
  EXPECT_TRUE(head.weights.allFinite() && head.bias.allFinite());
  const MatrixXd sigma = codegen::deviations(head, samples.hidden, samples.known);
  EXPECT_TRUE((sigma.array() > 0.0).all() && sigma.allFinite());
  EXPECT_NEAR(sigma(1, 0), 0.5, 1e-6);
}

}  // namespace
}  // namespace nlo::trainer
