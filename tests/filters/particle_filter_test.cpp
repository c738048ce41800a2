// SPDX-License-Identifier: MIT
#include "trainer/filters/particle_filter.h"

#include <gtest/gtest.h>

#include "tests/filters/lanes.h"

namespace nlo::trainer {
namespace {

using Eigen::ArrayXd;
using Eigen::MatrixXd;

constexpr double kSlowPeriod = 0.1;

TEST(ParticleFilter, OfALinearPlantWithGaussianNoiseIsTheKalmanFilter) {
  constexpr double kProcess = 0.5, kOutput = 0.4;
  constexpr Eigen::Index kSamples = 300;
  SimulationConfig simulation;
  simulation.initial_distribution = InitialDistribution::kGaussian;
  simulation.initial_low = {-1.0};
  simulation.initial_high = {1.0};  // deviation 1
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
  // A mean of N particles is off by about deviation / sqrt(N / 2), and remembers the samples before: three times that.
  EXPECT_LT((drawn - exact).norm() / std::sqrt(300.0), 3.0 * deviation / std::sqrt(1000.0));
  EXPECT_GT((x - exact).norm() / std::sqrt(300.0), 0.7 * deviation) << "control: that is far below the filter's error";
}

TEST(ParticleFilter, LearnsABiasThatAKalmanFilterTakesForTheState) {
  SimulationConfig simulation;
  simulation.initial_low = {-1.0};
  simulation.initial_high = {1.0};
  NoiseConfig noise = parse_noise("gaussian:0.1+bias:2");
  const MatrixXd y = MatrixXd::Constant(1, 200, 1.5) + 0.1 * test::normals(1, 200, 4);
  // x decays to 0 within the run: what is left is the bias.
  const MatrixXd x =
      particle_estimates(test::decay(0.5), simulation, 1.0, noise, test::runs_of(y, kSlowPeriod), {500, 3}, 0);
  EXPECT_NEAR(x(0, 199), 0.0, 0.05);
}

TEST(ParticleFilter, LosesTheParticlesThatThePlantCarriesOutOfTheNumbers) {
  // dx/dt = x^3 escapes within 1 / (2 x^2): most of the particles do before the first 5 s are over,
  // and the truth, 0.1, not.
  LanePlant plant = test::decay(0.5);
  plant.f = [](const MatrixXd& x, const MatrixXd&) { return MatrixXd(x.array().cube()); };
  SimulationConfig simulation;
  simulation.initial_low = {-3.0};
  simulation.initial_high = {3.0};
  const MatrixXd y = MatrixXd::Constant(1, 50, 0.1) + 0.5 * test::normals(1, 50, 4);
  const MatrixXd x = particle_estimates(plant, simulation, 1.0, parse_noise("gaussian:0.5"),
                                        test::runs_of(y, kSlowPeriod), {500, 3}, 0);
  ASSERT_TRUE(x.allFinite());
  EXPECT_NEAR(x(0, 49), 0.1, 0.15);  // twice what is left after 50 samples, 0.5 / sqrt(50)
}

TEST(ParticleFilter, HasDensitiesThatIntegrateToOne) {
  constexpr Eigen::Index kPoints = 400001;
  const ArrayXd v = ArrayXd::LinSpaced(kPoints, -200.0, 200.0);
  for (const char* text : {"gaussian:0.5", "uniform:3", "student:0.5:2", "gaussian:0.5+outliers:0.05:10",
                           "none+quantised:0.25", "gaussian:0.1+quantised:0.5"}) {
    const double sum = log_likelihood(parse_noise(text).of(0), v).exp().sum() * (v[1] - v[0]);
    EXPECT_NEAR(sum, 1.0, 2e-3) << text;  // the tails of Student's t, and soft edges
  }
}

TEST(ParticleFilter, SaysWhatItHasNoLikelihoodFor) {
  EXPECT_EQ(no_likelihood(parse_noise("gaussian:0.5+bias:1+outliers:0.1:5+missing:0.2")), "");
  EXPECT_NE(no_likelihood(parse_noise("gaussian:0.5+delay:2")), "");
  EXPECT_NE(no_likelihood(parse_noise("none")), "");
}

}  // namespace
}  // namespace nlo::trainer
