// SPDX-License-Identifier: MIT
#include "trainer/plants/initial_states.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

SimulationConfig box(InitialDistribution distribution = InitialDistribution::kUniform) {
  SimulationConfig config;
  config.initial_low = {-1.0, 2.0};
  config.initial_high = {1.0, 6.0};
  config.initial_distribution = distribution;
  return config;
}

TEST(InitialStates, AreTheSameNumbersOnEveryPlatform) {
  // From a separate implementation of SplitMix64 and mt19937_64, following the construction in the header.
  EXPECT_EQ(initial_state_seed(1, SeedStream::kTest), 0xF893A2EEFB32555Eu);
  SimulationConfig config;
  config.initial_low = {-1.0, -1.0};
  config.initial_high = {1.0, 1.0};
  Eigen::MatrixXd expected(2, 2);
  expected << -0.41874581652256104, 0.9779183385114385, 0.7858951196422861, 0.36149772072125663;
  EXPECT_EQ(draw_initial_states(config, initial_state_seed(1, SeedStream::kTest), 2), expected);
}

TEST(InitialStates, FillTheBoxEvenly) {
  constexpr Eigen::Index kCount = 20000;
  const Eigen::MatrixXd x = draw_initial_states(box(), 7, kCount);
  EXPECT_GE(x.row(0).minCoeff(), -1.0);
  EXPECT_LT(x.row(0).maxCoeff(), 1.0);
  EXPECT_GE(x.row(1).minCoeff(), 2.0);
  EXPECT_LT(x.row(1).maxCoeff(), 6.0);
  // Four standard errors: 4 / sqrt(12 * 20000) = 0.008 for the mean, and 0.008 for the variance 16/12.
  EXPECT_NEAR(x.row(1).mean(), 4.0, 0.033);
  EXPECT_NEAR((x.row(1).array() - 4.0).square().mean(), 16.0 / 12.0, 0.034);
}

TEST(InitialStates, GaussianHasTheHalfWidthAsDeviation) {
  constexpr Eigen::Index kCount = 20000;
  const Eigen::MatrixXd x = draw_initial_states(box(InitialDistribution::kGaussian), 7, kCount);
  // sigma = 2. Four standard errors: 0.014 for the mean, 4 sqrt(2 / 20000) = 0.04 for the variance. The kurtosis is 3.
  const Eigen::ArrayXd d = x.row(1).array() - 4.0;
  EXPECT_NEAR(d.mean(), 0.0, 0.057);
  EXPECT_NEAR(d.square().mean(), 4.0, 0.16);
  EXPECT_NEAR(d.square().square().mean() / (d.square().mean() * d.square().mean()), 3.0, 0.2);
}

TEST(InitialStates, ScaleAboutTheCentreOfTheBox) {
  const Eigen::MatrixXd one = draw_initial_states(box(), 7, 10), two = draw_initial_states(box(), 7, 10, 2.0);
  const Eigen::Vector2d centre(0.0, 4.0);
  EXPECT_LE(((two.colwise() - centre) - 2.0 * (one.colwise() - centre)).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(InitialStates, FirstStatesDoNotDependOnTheNumberOfStates) {
  EXPECT_EQ(draw_initial_states(box(), 7, 5), draw_initial_states(box(), 7, 50).leftCols(5));
  EXPECT_EQ(draw_initial_states(box(InitialDistribution::kGaussian), 7, 5),
            draw_initial_states(box(InitialDistribution::kGaussian), 7, 50).leftCols(5));
}

TEST(InitialStates, StreamsAndSeedsDiffer) {
  std::vector<Eigen::MatrixXd> sets;
  for (std::uint64_t seed : {0u, 1u, 2u})
    for (auto stream : {SeedStream::kTraining, SeedStream::kValidation, SeedStream::kTest})
      sets.push_back(draw_initial_states(box(), initial_state_seed(seed, stream), 3));
  for (std::size_t i = 0; i < sets.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(sets[i], sets[j]);
}

TEST(InitialStates, AreConstantIfTheBoxHasNoWidth) {
  SimulationConfig config = box();
  config.initial_low[0] = config.initial_high[0] = 0.25;
  for (const auto distribution : {InitialDistribution::kUniform, InitialDistribution::kGaussian}) {
    config.initial_distribution = distribution;
    const Eigen::MatrixXd x = draw_initial_states(config, 7, 20, 2.0);
    EXPECT_TRUE((x.row(0).array() == 0.25).all());
    EXPECT_GT(x.row(1).maxCoeff() - x.row(1).minCoeff(), 1.0);
  }
}

/// An ellipse in three states, in a plane that is tilted against all axes.
SimulationConfig ellipse() {
  SimulationConfig config;
  config.initial_distribution = InitialDistribution::kCircle;
  config.initial_centre = {1.0, 0.0, -1.0};
  config.initial_axes = {{2.0, 0.0, 1.0}, {0.0, 3.0, 0.5}};
  return config;
}

TEST(InitialStates, LieEvenlyOnTheCircle) {
  constexpr Eigen::Index kCount = 4000;
  for (const double scale : {1.0, 2.0}) {
    const Eigen::MatrixXd x = draw_initial_states(ellipse(), 7, kCount, scale);
    const Eigen::ArrayXd cosine = (x.row(0).array() - 1.0) / (2.0 * scale), sine = x.row(1).array() / (3.0 * scale);
    EXPECT_LE((cosine.square() + sine.square() - 1.0).abs().maxCoeff(), 1e-14);
    EXPECT_LE((x.row(2).transpose().array() + 1.0 - scale * (cosine + 0.5 * sine)).abs().maxCoeff(), 1e-14);
    // Each half of the circle holds half of the points: four standard errors of a share of 4,000, each 0.008.
    for (const Eigen::ArrayXd& side : {cosine, sine, Eigen::ArrayXd(cosine - sine)})
      EXPECT_NEAR((side > 0.0).cast<double>().mean(), 0.5, 0.032);
  }
  SimulationConfig at_origin = ellipse();
  at_origin.initial_centre.clear();
  EXPECT_LE((draw_initial_states(at_origin, 7, 3).colwise() + Eigen::Vector3d(1.0, 0.0, -1.0) -
             draw_initial_states(ellipse(), 7, 3))
                .cwiseAbs()
                .maxCoeff(),
            1e-15);
}

SimulationConfig list() {
  SimulationConfig config;
  config.initial_distribution = InitialDistribution::kList;
  config.initial_states = {{1.0, 10.0}, {2.0, 20.0}, {3.0, 30.0}, {6.0, 40.0}};
  return config;
}

TEST(InitialStates, UseEachStateOfAListOncePerRoundInRandomOrder) {
  const Eigen::MatrixXd x = draw_initial_states(list(), 7, 400);
  int orders = 0;
  for (Eigen::Index round = 0; round < 100; ++round) {
    const Eigen::RowVectorXd first = x.row(0).segment(4 * round, 4);
    for (const double state : {1.0, 2.0, 3.0, 6.0}) EXPECT_EQ((first.array() == state).count(), 1);
    orders += round > 0 && first != x.row(0).segment(4 * (round - 1), 4) ? 1 : 0;
  }
  EXPECT_GT(orders, 80);  // 24 orders: 99 * 23 / 24 = 95 changes are expected, with a standard deviation of 2
  for (Eigen::Index k = 0; k < x.cols(); ++k) EXPECT_EQ(x(1, k), x(0, k) == 6.0 ? 40.0 : 10.0 * x(0, k));
  EXPECT_EQ(draw_initial_states(list(), 7, 6), x.leftCols(6));
  EXPECT_NE(draw_initial_states(list(), 8, 400), x);
}

TEST(InitialStates, ScaleAListAboutItsMeanAndKeepASingleState) {
  const Eigen::Vector2d mean(3.0, 25.0);
  const Eigen::MatrixXd one = draw_initial_states(list(), 7, 8), two = draw_initial_states(list(), 7, 8, 2.0);
  EXPECT_LE(((two.colwise() - mean) - 2.0 * (one.colwise() - mean)).cwiseAbs().maxCoeff(), 1e-14);
  SimulationConfig fixed = list();
  fixed.initial_states = {{0.3, -0.7}};
  EXPECT_EQ(draw_initial_states(fixed, 7, 5, 3.0), Eigen::Vector2d(0.3, -0.7).replicate(1, 5));
}

TEST(InitialStates, HaveTheStatedMomentsAndBox) {
  constexpr Eigen::Index kCount = 40000;
  for (const SimulationConfig& config : {box(), box(InitialDistribution::kGaussian), ellipse(), list()}) {
    SCOPED_TRACE(to_name(config.initial_distribution));
    const Eigen::MatrixXd x = draw_initial_states(config, 3, kCount);
    const auto [mean, covariance] = initial_moments(config);
    const Eigen::VectorXd deviation = covariance.diagonal().cwiseSqrt();
    const Eigen::MatrixXd from_mean = x.colwise() - mean;
    const Eigen::MatrixXd sampled = from_mean * from_mean.transpose() / static_cast<double>(kCount);
    // Four standard errors, relative to the deviations: 1 / 200 for a mean, at most sqrt(2) / 200 for a covariance.
    EXPECT_LE((from_mean.rowwise().mean().array() / deviation.array()).abs().maxCoeff(), 0.02);
    EXPECT_LE(((sampled - covariance).array() / (deviation * deviation.transpose()).array()).abs().maxCoeff(), 0.03);
    if (config.initial_distribution == InitialDistribution::kGaussian) continue;
    const auto [low, high] = initial_box(config);
    EXPECT_GE((x.colwise() - low).minCoeff(), -1e-12);
    EXPECT_LE((x.colwise() - high).maxCoeff(), 1e-12);
    const Eigen::VectorXd width = high - low, reached = x.rowwise().maxCoeff() - x.rowwise().minCoeff();
    EXPECT_GE((reached.array() / width.array()).minCoeff(), 0.99) << "control: the box is not larger than necessary";
  }
}

}  // namespace
}  // namespace nlo::trainer
