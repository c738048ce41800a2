// SPDX-License-Identifier: MIT
// The noise in training: each sensor has its own; noise of an angle is added to the angle, not to its sine and cosine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "trainer/rollout/rollout.h"

#include "tests/support/mirrored.h"

namespace nlo::trainer {
namespace {

/// A latent system without a state: the tests read only the outputs.
class NoLatent final : public LatentDynamics {
 public:
  NoLatent() : LatentDynamics(1) {}
  void prepare(const float*) override {}
  void forward(SegmentGroup&, int) override {}
  void backward(SegmentGroup&, int) override {}
};

constexpr int kRuns = 16, kSamples = 401;  // odd, because normal numbers are drawn in pairs

/// Outputs: a = 0, an angle of 0.5 rad (as sine and cosine if encoded), b = 0.
Dataset still(bool encoded) {
  Dataset data;
  data.outputs = encoded ? std::vector<Channel>{{"a", "", 0.0}, {"q_sin", "", 0.0}, {"q_cos", "", 0.0}, {"b", "", 0.0}}
                         : std::vector<Channel>{{"a", "", 0.0}, {"b", "", 0.0}, {"c", "", 0.0}};
  if (encoded) data.output_angles = {{1, 2.0 * std::numbers::pi}};
  data.states = {{"x", "", 0.0}};
  data.sample_period_s = 0.01;
  for (int r = 0; r < kRuns; ++r) {
    Trajectory run;
    run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.01 * (kSamples - 1));
    run.outputs = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(data.outputs.size()), kSamples);
    if (encoded) {
      run.outputs.row(1).setConstant(std::sin(0.5));
      run.outputs.row(2).setConstant(std::cos(0.5));
    }
    run.states = Eigen::MatrixXd::Zero(1, kSamples);
    run.weight = Eigen::VectorXd::Ones(kSamples);
    data.trajectories.push_back(std::move(run));
  }
  return data;
}

/// Returns all samples of each output: n_y x (runs * samples).
Eigen::MatrixXd noisy(const Dataset& dataset, const NoiseConfig& noise) {
  const TrainingData data(dataset);
  Rollout rollout(data);
  NoLatent latent;
  ThreadPool pool(2);
  rollout.run(whole_runs(data), latent, noise, 1, Purpose::kNoise, 0, pool);
  Eigen::MatrixXd all(data.ny, kRuns * kSamples);
  Eigen::Index column = 0;
  for (const SegmentGroup& group : rollout.groups())
    for (int t = 0; t < group.length; ++t)
      for (int l = 0; l < group.lanes; ++l, ++column)
        for (int j = 0; j < data.ny; ++j)
          all(j, column) = static_cast<double>(group.readings[group.at(j, t) + static_cast<std::size_t>(l)]);
  return all;
}

// Four standard errors of a deviation from 6,416 draws, each 0.9 %.
constexpr double kDeviationTolerance = 0.036;

TEST(RolloutNoise, IsIndependentForEachSensor) {
  const Eigen::MatrixXd y = noisy(still(false), parse_noise("gaussian:0.5,none,uniform:0.02"));
  EXPECT_NEAR(std::sqrt(y.row(0).squaredNorm() / static_cast<double>(y.cols())), 0.5, 0.5 * kDeviationTolerance);
  EXPECT_TRUE((y.row(1).array() == 0.0).all());
  EXPECT_LE(y.row(2).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_NEAR(std::sqrt(3.0 * y.row(2).squaredNorm() / static_cast<double>(y.cols())), 0.02,
              0.02 * kDeviationTolerance);
}

TEST(RolloutNoise, HasTailsOutliersBiasesAndSteps) {
  const Eigen::MatrixXd y =
      noisy(still(false), parse_noise("student:0.5:2,none+outliers:0.2:6,none+bias:0.4+quantised:0.1"));
  const auto share = [&](const auto& row) { return row.template cast<double>().mean(); };
  // 6,416 draws: three standard errors are .019 and .015; the bias has only 16 draws, one for each run.
  EXPECT_NEAR(share((y.row(0).array().abs() < 0.5)), 1.0 / std::sqrt(3.0), 0.019);
  EXPECT_NEAR(share((y.row(1).array() != 0.0)), 0.2, 0.015);
  EXPECT_LE(y.row(1).cwiseAbs().maxCoeff(), 6.0);
  EXPECT_LE((y.row(2) * 10.0 - (y.row(2) * 10.0).array().round().matrix()).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_GT(y.row(2).cwiseAbs().maxCoeff(), 0.15);
  EXPECT_LE(y.row(2).cwiseAbs().maxCoeff(), 0.4 + 1e-6);
}

TEST(RolloutNoise, AMixtureAlternatesBetweenGroupsOfTrajectories) {
  const TrainingData data(still(false));
  Rollout rollout(data);
  NoLatent latent;
  ThreadPool pool(2);
  const NoiseMixture mixture({parse_noise("none"), parse_noise("uniform:0.02"), parse_noise("gaussian:5")});
  ASSERT_EQ(kRuns, 2 * kGroup);
  for (const std::uint64_t step : {0U, 1U, 2U, 7U}) {
    rollout.run(whole_runs(data), latent, mixture, 1, Purpose::kNoise, step, pool);
    for (std::size_t g = 0; g < 2; ++g) {
      float largest = 0.0F;
      for (const float y : rollout.groups()[g].readings) largest = std::max(largest, std::fabs(y));
      const std::size_t part = (2 * step + g) % 3;
      EXPECT_EQ(largest == 0.0F, part == 0) << step;
      EXPECT_EQ(largest > 1.0F, part == 2) << step;
    }
  }
}

TEST(RolloutNoise, ClampsOutliersAsInFlight) {
  Dataset data = still(false);
  for (Trajectory& run : data.trajectories) run.outputs.row(0).setLinSpaced(-1.0, 3.0);
  const Eigen::MatrixXd tails = noisy(data, parse_noise("student:2:1,none,none"));
  EXPECT_EQ(tails.row(0).minCoeff(),
            -17.0);  // the range [-1, 3] of the data, extended on each side by its width (4) and six noise scales (12)
  EXPECT_EQ(tails.row(0).maxCoeff(), 19.0);
  const Eigen::MatrixXd outliers = noisy(data, parse_noise("none+outliers:0.1:50,none,none"));
  EXPECT_EQ(outliers.row(0).maxCoeff(), 7.0);
  EXPECT_GT(noisy(data, parse_noise("gaussian:4,none,none")).row(0).maxCoeff(), 9.0) << "control: no tails";
  // Mirror images range from -3 to 1.
  EXPECT_EQ(noisy(testing::mirrored(data), parse_noise("student:2:1,none,none")).row(0).minCoeff(), -21.0);
}

TEST(RolloutNoise, OneNoiseForAllEqualsTheSameNoiseForEach) {
  EXPECT_EQ(noisy(still(false), parse_noise("gaussian:0.5")),
            noisy(still(false), parse_noise("gaussian:0.5,gaussian:0.5,gaussian:0.5")));
}

TEST(RolloutNoise, IsAddedToTheAngleNotToItsSine) {
  constexpr double kFloat = 1e-6;
  const Eigen::MatrixXd y = noisy(still(true), parse_noise("none,gaussian:0.3,uniform:2"));
  EXPECT_TRUE((y.row(0).array() == 0.0).all());
  EXPECT_LE((y.row(1).array().square() + y.row(2).array().square() - 1.0).abs().maxCoeff(), kFloat);
  Eigen::ArrayXd error(y.cols());
  for (Eigen::Index k = 0; k < y.cols(); ++k) error(k) = std::atan2(y(1, k), y(2, k)) - 0.5;
  EXPECT_NEAR(std::sqrt(error.square().mean()), 0.3, 0.3 * kDeviationTolerance);
  EXPECT_NEAR(error.mean(), 0.0, 4.0 * 0.3 / std::sqrt(static_cast<double>(y.cols())));
  EXPECT_GT(y.row(3).cwiseAbs().maxCoeff(), 1.5) << "the third sensor follows the angle";
}

TEST(RolloutNoise, ClipsAndRoundsTheAngleNotItsSine) {
  constexpr double kFloat = 1e-5;  // a reading of 1.5 rad in steps of 0.1 rad
  const Eigen::MatrixXd y = noisy(still(true), parse_noise("none,uniform:1+clipped:0.9+quantised:0.1,none"));
  double largest = 0.0, smallest = 1.0;
  for (Eigen::Index k = 0; k < y.cols(); ++k) {
    const double steps = 10.0 * std::atan2(y(1, k), y(2, k));
    ASSERT_NEAR(steps, std::round(steps), 10.0 * kFloat);
    largest = std::max(largest, steps);
    smallest = std::min(smallest, steps);
  }
  EXPECT_NEAR(largest, 9.0, 10.0 * kFloat) << "clipped";
  EXPECT_NEAR(smallest, -5.0, 10.0 * kFloat) << "0.5 rad and noise of up to 1 rad";
}

}  // namespace
}  // namespace nlo::trainer
