// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/filter_bank.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/filters/lanes.h"
#include "trainer/judge/filters/moving_horizon.h"
#include "trainer/judge/filters/particle_filter.h"

namespace nlo::trainer {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;

constexpr double kStep = 0.02;

/// dx/dt = -0.3 x, y = (x - 1)^2: two states explain each output, and only the course of y decides between them.
LanePlant ambiguous() {
  LanePlant plant = test::decay(0.3);
  plant.h = [](const MatrixXd& x, const MatrixXd&) { return MatrixXd((x.array() - 1.0).square()); };
  return plant;
}

/// A run from x0 without noise: x in the first row, y in the second.
MatrixXd run_from(double x0) {
  MatrixXd run(2, 101);
  for (Eigen::Index k = 0; k < run.cols(); ++k) {
    run(0, k) = x0 * std::pow(test::rk4_decay(0.3, kStep), static_cast<double>(k));
    run(1, k) = std::pow(run(0, k) - 1.0, 2);
  }
  return run;
}

FilterKnowledge wide_start() {
  FilterKnowledge known = test::scalar_knowledge(1.5, 1e-3, 0.05);
  known.initial_state[0] = 0.9;
  return known;
}

FilterKnowledge an_eighth_of(FilterKnowledge known) {
  known.initial_covariance /= 64.0;
  return known;
}

double error_at_the_end(LaneFilter& filter, const MatrixXd& run) {
  const MatrixXd x = test::estimates_of(filter, test::runs_of(run.row(1), kStep));
  return std::abs(x(0, x.cols() - 1) - run(0, x.cols() - 1));
}

TEST(FilterBank, FindsTheStateThatOneFilterMisses) {
  const MatrixXd starts = Eigen::RowVectorXd::LinSpaced(8, -1.5, 3.5);
  double worst_of_one = 0.0;
  for (const double x0 : {-0.5, 2.5}) {
    FilterBank bank(ambiguous(), PointSet::kExtended, an_eighth_of(wide_start()), starts, {{}}, 1);
    EXPECT_LT(error_at_the_end(bank, run_from(x0)), 0.02) << x0;
    EXPECT_NEAR(bank.weights().col(0).sum(), 1.0, 1e-12);
    SigmaPointFilter one(ambiguous(), PointSet::kExtended, wide_start(), {{}}, 1);
    worst_of_one = std::max(worst_of_one, error_at_the_end(one, run_from(x0)));
  }
  EXPECT_GT(worst_of_one, 0.3) << "control: a single filter converges to the other state that explains the outputs";
}

TEST(FilterBank, WithOneMemberEqualsThatFilter) {
  const MatrixXd run = run_from(0.7);
  FilterBank bank(ambiguous(), PointSet::kExtended, wide_start(), MatrixXd::Constant(1, 1, 0.9), {{}}, 1);
  SigmaPointFilter one(ambiguous(), PointSet::kExtended, wide_start(), {{}}, 1);
  const LaneRuns runs = test::runs_of(run.row(1), kStep);
  EXPECT_EQ(test::estimates_of(bank, runs), test::estimates_of(one, runs));
}

TEST(FilterBank, TreatsLanesIndependently) {
  const LaneRuns one = test::runs_of(run_from(2.5).row(1), kStep), three = repeated(one, 3);
  const MatrixXd starts = Eigen::RowVectorXd::LinSpaced(4, -1.5, 3.5);
  FilterTuning trusting;
  trusting.output = 0.1;
  FilterBank all(ambiguous(), PointSet::kExtended, wide_start(), starts, {{}, trusting, {}}, 3);
  FilterBank middle(ambiguous(), PointSet::kExtended, wide_start(), starts, {trusting}, 1);
  for (Eigen::Index k = 0; k < one.samples(); ++k) {
    const MatrixXd x = all.step(three, k);
    EXPECT_NEAR(x(0, 1), middle.step(one, k)(0, 0), 1e-9) << "the same sums except for fused multiply-adds";
    EXPECT_NEAR(x(0, 0), x(0, 2), 1e-9);
  }
}

TEST(FilterBank, AveragesAnglesTheShortWayRound) {
  // x is constant, and no measurement distinguishes two filters that are .2 apart across the end of a turn of 6.
  LanePlant plant = test::decay(0.0);
  plant.h = [](const MatrixXd& x, const MatrixXd&) { return MatrixXd(0.0 * x); };
  const LaneRuns run = test::runs_of(MatrixXd::Zero(1, 2), kStep);
  const auto mean = [&] {
    FilterBank bank(plant, PointSet::kUnscented, test::scalar_knowledge(1e-3, 0.0, 1.0), Eigen::RowVector2d(3.0, -2.8),
                    {{}}, 1);
    return test::estimates_of(bank, run)(0, 1);
  };
  EXPECT_NEAR(mean(), 0.1, 1e-9) << "control: the mean of a state that is not an angle";
  plant.state_wraps = Eigen::VectorXd::Constant(1, 6.0);
  EXPECT_NEAR(mean(), 3.1, 1e-9) << "-2.8 is the same angle as 3.2";
}

constexpr double kHorizonPeriod = 0.02;

TEST(MovingHorizon, EqualsTheKalmanFilterForALinearPlantWithoutProcessNoise) {
  // One Gauss-Newton step solves a linear problem. Least squares over the window, with the filter's prediction as
  // prior, equals least squares over all samples: the estimate of the Kalman filter.
  const MatrixXd y = MatrixXd::Constant(1, 120, 1.0) + 0.3 * test::normals(1, 120, 5);
  const FilterKnowledge known = test::scalar_knowledge(1.0, 0.0, 0.3);
  const LaneRuns runs = test::runs_of(y, kHorizonPeriod);
  MovingHorizonFilter horizon(test::decay(0.5), known, {{}}, 1, 10);
  SigmaPointFilter kalman(test::decay(0.5), PointSet::kExtended, known, {{}}, 1);
  const MatrixXd own = test::estimates_of(horizon, runs), other = test::estimates_of(kalman, runs);
  EXPECT_LE((own - other).cwiseAbs().maxCoeff(), 1e-9);  // differences over 1e-4 of a standard deviation, in double
}

TEST(MovingHorizon, LimitsThePullOfAnOutlierToItsGate) {
  MatrixXd y = MatrixXd::Constant(1, 60, 0.0) + 0.1 * test::normals(1, 60, 6);
  const auto shift = [&](double gate, double outlier) {
    FilterTuning tuning;
    tuning.gate = gate;
    const auto last = [&](double v) {
      MatrixXd measured = y;
      measured(0, 55) += v;
      MovingHorizonFilter filter(test::decay(0.5), test::scalar_knowledge(1.0, 1e-2, 0.1), {tuning}, 1, 20);
      return test::estimates_of(filter, test::runs_of(measured, kHorizonPeriod))(0, 59);
    };
    return std::abs(last(outlier) - last(0.0));
  };
  const double open = std::numeric_limits<double>::infinity();
  // Iterated weights limit the pull of an outlier to that of a sample at the gate, however far away it lies.
  EXPECT_LT(shift(2.0, 100.0), 2.0 * shift(2.0, 10.0) + 1e-3);
  EXPECT_GT(shift(open, 100.0), 5.0 * shift(open, 10.0))
      << "control: without a gate the pull is proportional to the outlier";
}

constexpr double kSlowPeriod = 0.1;

TEST(ParticleFilter, EqualsTheKalmanFilterForALinearPlantWithGaussianNoise) {
  constexpr double kProcess = 0.5, kOutput = 0.4;
  constexpr Eigen::Index kSamples = 300;
  SimulationConfig simulation;
  simulation.initial_distribution = InitialDistribution::kGaussian;
  simulation.initial_low = {-1.0};
  simulation.initial_high = {1.0};  // standard deviation 1
  simulation.process_noise = {kProcess};
  const double phi = test::rk4_decay(0.5, kSlowPeriod);
  MatrixXd x(1, kSamples), w = test::normals(1, kSamples, 1), v = test::normals(1, kSamples, 2);
  x(0, 0) = 0.8;
  for (Eigen::Index k = 1; k < kSamples; ++k) x(0, k) = phi * x(0, k - 1) + kProcess * std::sqrt(kSlowPeriod) * w(0, k);
  const LaneRuns run = test::runs_of(x + kOutput * v, kSlowPeriod);
  SigmaPointFilter kalman(test::decay(0.5), PointSet::kExtended,
                          test::scalar_knowledge(1.0, kProcess * std::sqrt(kSlowPeriod), kOutput), {{}}, 1);
  const MatrixXd exact = test::estimates_of(kalman, run);
  const MatrixXd drawn =
      particle_estimates(test::decay(0.5), simulation, 1.0, {NoiseKind::kGaussian, kOutput}, run, {2000, 7}, 0);
  const double deviation = kalman.root()(0, 0)[0];
  // The mean of N particles errs by about deviation / sqrt(N / 2), correlated over samples; the tolerance is three
  // times that.
  EXPECT_LT((drawn - exact).norm() / std::sqrt(300.0), 3.0 * deviation / std::sqrt(1000.0));
  EXPECT_GT((x - exact).norm() / std::sqrt(300.0), 0.7 * deviation)
      << "control: the tolerance is far below the error of the filter";
}

TEST(ParticleFilter, EstimatesABiasThatAKalmanFilterAttributesToTheState) {
  SimulationConfig simulation;
  simulation.initial_low = {-1.0};
  simulation.initial_high = {1.0};
  NoiseConfig noise = parse_noise("gaussian:0.1+bias:2");
  const MatrixXd y = MatrixXd::Constant(1, 200, 1.5) + 0.1 * test::normals(1, 200, 4);
  // x decays to 0 within the run, so the remaining error is that of the bias.
  const MatrixXd x =
      particle_estimates(test::decay(0.5), simulation, 1.0, noise, test::runs_of(y, kSlowPeriod), {500, 3}, 0);
  EXPECT_NEAR(x(0, 199), 0.0, 0.05);
}

TEST(ParticleFilter, DropsParticlesThatEscapeToInfinity) {
  // dx/dt = x^3 escapes to infinity within 1 / (2 x^2): most of the particles do so in the first 5 s, the truth, which
  // starts at 0.1, does not.
  LanePlant plant = test::decay(0.5);
  plant.f = [](const MatrixXd& x, const MatrixXd&) { return MatrixXd(x.array().cube()); };
  SimulationConfig simulation;
  simulation.initial_low = {-3.0};
  simulation.initial_high = {3.0};
  const MatrixXd y = MatrixXd::Constant(1, 50, 0.1) + 0.5 * test::normals(1, 50, 4);
  const MatrixXd x = particle_estimates(plant, simulation, 1.0, parse_noise("gaussian:0.5"),
                                        test::runs_of(y, kSlowPeriod), {500, 3}, 0);
  ASSERT_TRUE(x.allFinite());
  EXPECT_NEAR(x(0, 49), 0.1, 0.15);  // twice the standard error after 50 samples, 0.5 / sqrt(50)
}

TEST(ParticleFilter, HasDensitiesThatIntegrateToOne) {
  constexpr Eigen::Index kPoints = 400001;
  const ArrayXd v = ArrayXd::LinSpaced(kPoints, -200.0, 200.0);
  for (const char* text : {"gaussian:0.5", "uniform:3", "student:0.5:2", "gaussian:0.5+outliers:0.05:10",
                           "none+quantised:0.25", "gaussian:0.1+quantised:0.5"}) {
    const double sum = log_likelihood(parse_noise(text).of(0), v).exp().sum() * (v[1] - v[0]);
    EXPECT_NEAR(sum, 1.0, 2e-3) << text;  // the tails of Student's t and discretised edges
  }
}

TEST(ParticleFilter, NamesNoisesWithoutALikelihood) {
  EXPECT_EQ(no_likelihood(parse_noise("gaussian:0.5+bias:1+outliers:0.1:5+missing:0.2")), "");
  EXPECT_NE(no_likelihood(parse_noise("gaussian:0.5+delay:2")), "");
  EXPECT_NE(no_likelihood(parse_noise("none")), "");
}

}  // namespace
}  // namespace nlo::trainer
