// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/coverage.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/filters/lanes.h"
#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Errors 0.1, 0.2, ..., 1.0 of a state, and of an angle with a turn subtracted.
Trajectory stairs() {
  Trajectory run;
  run.time_s = VectorXd::LinSpaced(10, 0.0, 9.0);
  run.states = MatrixXd::Zero(2, 10);
  run.states.row(0) = VectorXd::LinSpaced(10, 0.1, 1.0).transpose();
  run.states.row(1) = run.states.row(0).array() + 6.0;
  run.weight = VectorXd::Ones(10);
  return run;
}

Estimates of_width(double sigma, double bound_95) {
  return {MatrixXd::Zero(2, 10), MatrixXd::Constant(2, 10, sigma), MatrixXd::Constant(2, 10, bound_95)};
}

const std::vector<Channel> kStates = {{"x", "", 0.0}, {"angle", "", 6.0}};

TEST(Coverage, IsTheShareOfTheErrorsWithinTheIntervals) {
  CoverageSum sum(kStates);
  sum.add(stairs(), of_width(0.45, 0.85));
  const auto found = sum.coverage();
  ASSERT_TRUE(found);
  for (int i = 0; i < 2; ++i) {
    EXPECT_DOUBLE_EQ(found->share_68(i), 0.4);
    EXPECT_DOUBLE_EQ(found->share_95(i), 0.8);
    EXPECT_DOUBLE_EQ(found->sigma(i), 0.45);
  }
}

TEST(Coverage, LeavesOutMaskedAndEarlySamples) {
  Trajectory run = stairs();
  run.weight.tail(5).setZero();
  run.first_estimate = 1;
  CoverageSum sum(kStates);
  sum.add(run, of_width(0.45, 0.85));
  EXPECT_DOUBLE_EQ(sum.coverage()->share_68(0), 0.75);  // 0.2, 0.3, 0.4 and 0.5
  run.weight.setZero();
  CoverageSum none(kStates);
  none.add(run, of_width(0.45, 0.85));
  EXPECT_FALSE(none.coverage());
}

TEST(Coverage, CountsSamplesWithoutAnIntervalSeparately) {
  Estimates estimates = of_width(0.45, 0.85);
  estimates.sigma.rightCols(5).setConstant(static_cast<double>(kUnknownSigma));
  estimates.bound_95.rightCols(5).setConstant(static_cast<double>(kUnknownSigma));
  CoverageSum sum(kStates);
  sum.add(stairs(), estimates);
  EXPECT_DOUBLE_EQ(sum.coverage()->unknown(0), 0.5);
  EXPECT_DOUBLE_EQ(sum.coverage()->share_68(0), 0.8);  // 0.1, ..., 0.4 and 0.5
  EXPECT_DOUBLE_EQ(sum.coverage()->share_95(0), 1.0);
  EXPECT_DOUBLE_EQ(sum.coverage()->sigma(0), 0.45);
}

TEST(Coverage, PartsAddUpToTheWhole) {
  CoverageSum whole(kStates), part(kStates), rest(kStates);
  whole.add(stairs(), of_width(0.45, 0.85));
  whole.add(stairs(), of_width(0.15, 0.25));
  part.add(stairs(), of_width(0.45, 0.85));
  rest.add(stairs(), of_width(0.15, 0.25));
  part.merge(rest);
  EXPECT_EQ(part.coverage()->share_68, whole.coverage()->share_68);
  EXPECT_TRUE(part.coverage()->sigma.isApprox(whole.coverage()->sigma, 1e-14));  // summed in another order
  const auto mean = mean_coverage({part.coverage(), whole.coverage()});
  ASSERT_TRUE(mean);
  EXPECT_EQ(mean->share_95, whole.coverage()->share_95);
  EXPECT_FALSE(mean_coverage({part.coverage(), std::nullopt}));
}

/// A random walk x+ = x + w with y = x + v: a Kalman filter is optimal and predicts its own error.
TEST(Coverage, EqualsTheNominalShareForAKalmanFilterOnItsPlant) {
  constexpr double kStep = 0.1, kNoise = 0.5;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  Dataset runs;
  runs.outputs = {{"y", "", 0.0}};
  runs.states = {{"x", "", 0.0}};
  runs.sample_period_s = 1.0;
  for (int r = 0; r < 40; ++r) {
    Trajectory run;
    run.time_s = VectorXd::LinSpaced(500, 0.0, 499.0);
    run.states.resize(1, 500);
    double x = normal(random);
    for (double& state : run.states.row(0)) {
      state = x;
      x += kStep * normal(random);
    }
    run.outputs = run.states;
    run.weight = VectorXd::Ones(500);
    runs.trajectories.push_back(run);
  }
  const auto kalman = [](double output) -> EstimatorFactory {
    return [output]() -> Estimator {
      return [output](const MatrixXd& y, const MatrixXd& u, const VectorXd& time_s) {
        SigmaPointFilter filter(test::decay(0.0), PointSet::kExtended, test::scalar_knowledge(1.0, kStep, output), {{}},
                                1);
        const FilteredRun run = filtered(filter, one_run(y, u, time_s, false));
        return normal_intervals(run.x_hat, run.deviations);
      };
    };
  };
  const NoiseConfig noise{NoiseKind::kGaussian, kNoise};
  const auto found = evaluate("", kalman(kNoise), runs, noise, 3, 1).coverage;
  ASSERT_TRUE(found);
  // Errors decorrelate within about 5 samples, so 20,000 samples count as 2,000 draws; four binomial deviations.
  EXPECT_NEAR(found->share_68(0), 0.68, 4.0 * std::sqrt(0.68 * 0.32 / 2000.0));
  EXPECT_NEAR(found->share_95(0), 0.95, 4.0 * std::sqrt(0.95 * 0.05 / 2000.0));
  // Control: a filter that assumes three times the noise.
  const auto cautious = evaluate("", kalman(3.0 * kNoise), runs, noise, 3, 1).coverage;
  EXPECT_GT(cautious->share_68(0), 0.68 + 4.0 * std::sqrt(0.68 * 0.32 / 2000.0));
}

TEST(Coverage, HasTheSameBytesForAnyNumberOfThreads) {
  Dataset runs;
  runs.outputs = {{"y", "", 0.0}};
  runs.states = kStates;
  runs.sample_period_s = 1.0;
  for (int r = 0; r < 11; ++r) {
    runs.trajectories.push_back(stairs());
    runs.trajectories.back().outputs = MatrixXd::Constant(1, 10, 0.1 * r);
  }
  const EstimatorFactory factory = [] {
    return [](const MatrixXd& y, const MatrixXd&, const VectorXd&) {
      return Estimates{MatrixXd::Zero(2, 10), y.replicate(2, 1).cwiseAbs(), 2.0 * y.replicate(2, 1).cwiseAbs()};
    };
  };
  const NoiseConfig noise{NoiseKind::kGaussian, 0.3};
  const auto one = evaluate("", factory, runs, noise, 1, 1).coverage,
             three = evaluate("", factory, runs, noise, 1, 3).coverage;
  EXPECT_EQ(one->share_68, three->share_68);
  EXPECT_EQ(one->sigma, three->sigma);
}

}  // namespace
}  // namespace nlo::trainer
