// SPDX-License-Identifier: MIT
#include "trainer/plants/initial_states.h"

#include <gtest/gtest.h>

namespace nlo::trainer {
namespace {

SimulationConfig box(const std::string& distribution = "uniform") {
  SimulationConfig config;
  config.initial_low = {-1.0, 2.0};
  config.initial_high = {1.0, 6.0};
  config.initial_distribution = distribution;
  return config;
}

TEST(InitialStates, AreTheseNumbersOnEveryPlatform) {
  // From a separate implementation of SplitMix64 and mt19937_64 by the construction in the header.
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
  // Standard error of the mean: 4 / sqrt(12 * 20000) = 0.008; of the variance 16/12: 0.008. Four of them.
  EXPECT_NEAR(x.row(1).mean(), 4.0, 0.033);
  EXPECT_NEAR((x.row(1).array() - 4.0).square().mean(), 16.0 / 12.0, 0.034);
}

TEST(InitialStates, GaussianHasTheHalfWidthAsDeviation) {
  constexpr Eigen::Index kCount = 20000;
  const Eigen::MatrixXd x = draw_initial_states(box("gaussian"), 7, kCount);
  // sigma = 2: standard error of the mean 0.014, of the variance 4 sqrt(2 / 20000) = 0.04; four of them. Kurtosis 3.
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

TEST(InitialStates, TheFirstDoNotDependOnHowManyFollow) {
  EXPECT_EQ(draw_initial_states(box(), 7, 5), draw_initial_states(box(), 7, 50).leftCols(5));
  EXPECT_EQ(draw_initial_states(box("gaussian"), 7, 5), draw_initial_states(box("gaussian"), 7, 50).leftCols(5));
}

TEST(InitialStates, StreamsAndSeedsDiffer) {
  std::vector<Eigen::MatrixXd> sets;
  for (std::uint64_t seed : {0u, 1u, 2u})
    for (auto stream : {SeedStream::kTraining, SeedStream::kValidation, SeedStream::kTest})
      sets.push_back(draw_initial_states(box(), initial_state_seed(seed, stream), 3));
  for (std::size_t i = 0; i < sets.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) EXPECT_NE(sets[i], sets[j]);
}

}  // namespace
}  // namespace nlo::trainer
