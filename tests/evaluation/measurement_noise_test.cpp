// SPDX-License-Identifier: MIT
#include "trainer/evaluation/measurement_noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace nlo::trainer {
namespace {

constexpr int kDraws = 200'000;
const NoiseConfig kGaussian{NoiseKind::kGaussian, 0.5}, kUniform{NoiseKind::kUniform, 3.0};

/// Mean of |v / scale|^power.
double moment(const NoiseConfig& noise, int power, std::uint64_t seed) {
  MeasurementNoise source(noise, seed, 0);
  double sum = 0.0;
  for (int i = 0; i < kDraws; ++i) sum += std::pow(source.draw() / noise.of(0).scale, power);
  return sum / kDraws;
}

TEST(MeasurementNoise, GaussianHasItsMoments) {
  // Five standard errors of each sample moment: sqrt(1, 2, 15, 96 / 200'000).
  EXPECT_NEAR(moment(kGaussian, 1, 7), 0.0, 5.0 * std::sqrt(1.0 / kDraws));
  EXPECT_NEAR(moment(kGaussian, 2, 7), 1.0, 5.0 * std::sqrt(2.0 / kDraws));
  EXPECT_NEAR(moment(kGaussian, 3, 7), 0.0, 5.0 * std::sqrt(15.0 / kDraws));
  EXPECT_NEAR(moment(kGaussian, 4, 7), 3.0, 5.0 * std::sqrt(96.0 / kDraws));
}

TEST(MeasurementNoise, UniformHasItsMomentsAndBounds) {
  EXPECT_NEAR(moment(kUniform, 1, 7), 0.0, 5.0 * std::sqrt(1.0 / 3.0 / kDraws));
  EXPECT_NEAR(moment(kUniform, 2, 7), 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / kDraws));
  MeasurementNoise source(kUniform, 1, 2);
  for (int i = 0; i < kDraws; ++i) ASSERT_LE(std::abs(source.draw()), 3.0);
}

TEST(MeasurementNoise, NeighbouringDrawsAreIndependent) {
  MeasurementNoise source(kGaussian, 3, 0);
  double previous = source.draw(), sum = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double next = source.draw();
    sum += previous * next / 0.25;
    previous = next;
  }
  EXPECT_NEAR(sum / kDraws, 0.0, 5.0 / std::sqrt(kDraws));
}

TEST(MeasurementNoise, SameSeedAndRunGiveTheSameBits) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Zero(2, 50);
  EXPECT_EQ(MeasurementNoise(kGaussian, 5, 9).on(clean), MeasurementNoise(kGaussian, 5, 9).on(clean));
}

TEST(MeasurementNoise, OtherSeedsAndRunsAreUnrelated) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Zero(1, 1000);
  const Eigen::MatrixXd one = MeasurementNoise(kGaussian, 5, 9).on(clean);
  // Seed 5 run 9, and what a naive seed + run would confuse it with.
  for (const auto& [seed, run] : {std::pair{6, 8}, {5, 10}, {9, 5}, {14, 0}}) {
    const Eigen::MatrixXd other =
        MeasurementNoise(kGaussian, static_cast<std::uint64_t>(seed), static_cast<std::uint64_t>(run)).on(clean);
    const double correlation = one.cwiseProduct(other).sum() / (one.norm() * other.norm());
    EXPECT_LT(std::abs(correlation), 5.0 / std::sqrt(1000.0)) << seed << " " << run;
  }
}

TEST(MeasurementNoise, IsOfEachSensorItsOwn) {
  const NoiseConfig noise = parse_noise("gaussian:0.5,none,uniform:3");
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Constant(3, 5000, 2.0);
  const Eigen::MatrixXd v = MeasurementNoise(noise, 3, 0).on(clean) - clean;
  // Standard error of a deviation from 5,000 draws: 1 %; four of them.
  EXPECT_NEAR(std::sqrt(v.row(0).squaredNorm() / 5000.0), 0.5, 0.02);
  EXPECT_TRUE((v.row(1).array() == 0.0).all());
  EXPECT_NEAR(std::sqrt(v.row(2).squaredNorm() / 5000.0), std::sqrt(3.0), 0.07);
  EXPECT_LE(v.row(2).cwiseAbs().maxCoeff(), 3.0);
  EXPECT_EQ(noise_variances(noise), Eigen::Vector3d(0.25, 0.0, 3.0));
  EXPECT_EQ(noise_title(noise), "N(0, 0.5), no noise, U(-3, 3)");
}

TEST(MeasurementNoise, OfAnAngleIsOnTheAngleNotOnItsSine) {
  constexpr Eigen::Index kSamples = 100;
  constexpr double kDegree = 3.141592653589793 / 180.0;
  const Eigen::RowVectorXd angle = Eigen::RowVectorXd::LinSpaced(kSamples, -400.0, 400.0);
  Eigen::MatrixXd plain(2, kSamples), encoded(3, kSamples);
  plain << angle, angle;
  encoded << (kDegree * angle.array()).sin(), (kDegree * angle.array()).cos(), angle;
  const NoiseConfig noise{NoiseKind::kGaussian, 20.0};
  const Eigen::MatrixXd expected = MeasurementNoise(noise, 3, 0).on(plain);
  const Eigen::MatrixXd measured = MeasurementNoise(noise, 3, 0).on(encoded, {{0, 360.0}});
  // The same draws: the sine and the cosine of the angle that a plain sensor shows.
  EXPECT_LE((measured.row(0).array() - (kDegree * expected.row(0).array()).sin()).abs().maxCoeff(), 1e-13);
  EXPECT_LE((measured.row(1).array() - (kDegree * expected.row(0).array()).cos()).abs().maxCoeff(), 1e-13);
  EXPECT_EQ(measured.row(2), expected.row(1));
}

TEST(MeasurementNoise, StudentsTHasItsTails) {
  // P(|t_2| < x) = x / sqrt(2 + x^2), P(|t_1| < x) = 2 atan(x) / pi; 20,000 draws: three standard errors are .011.
  for (const auto& [text, x, share] : {std::tuple{"student:0.5:2", 1.0, 1.0 / std::sqrt(3.0)},
                                       {"student:0.5:2", 5.0, 5.0 / std::sqrt(27.0)},
                                       {"student:0.5:1", 2.0, 0.704833}}) {
    MeasurementNoise source(parse_noise(text), 4, 1);
    int within = 0;
    for (int i = 0; i < 20000; ++i) within += std::abs(source.draw()) < 0.5 * x ? 1 : 0;
    EXPECT_NEAR(within / 20000.0, share, 0.011) << text << " " << x;
  }
}

TEST(MeasurementNoise, OutliersComeInTheirShareAndABiasStaysForARun) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Constant(1, 20000, 1.0);
  const Eigen::MatrixXd v = MeasurementNoise(parse_noise("none+outliers:0.1:8"), 3, 0).on(clean) - clean;
  EXPECT_NEAR((v.array() != 0.0).cast<double>().mean(), 0.1, 0.007);  // three standard errors
  EXPECT_LE(v.cwiseAbs().maxCoeff(), 8.0);
  EXPECT_GT(v.cwiseAbs().maxCoeff(), 7.5);
  double least = 1e9, most = -1e9;
  for (std::uint64_t run = 0; run < 50; ++run) {
    const Eigen::MatrixXd biased = MeasurementNoise(parse_noise("none+bias:0.3"), 3, run).on(clean.leftCols(20));
    EXPECT_TRUE((biased.array() == biased(0, 0)).all());
    least = std::min(least, biased(0, 0) - 1.0);
    most = std::max(most, biased(0, 0) - 1.0);
  }
  EXPECT_TRUE(least < -0.2 && least >= -0.3 && most > 0.2 && most <= 0.3) << least << " " << most;
}

TEST(MeasurementNoise, AQuantisedSensorGivesMultiplesOfItsStep) {
  const Eigen::MatrixXd clean = Eigen::RowVectorXd::LinSpaced(500, -2.0, 2.0);
  const Eigen::MatrixXd shown = MeasurementNoise(parse_noise("none+quantised:0.25"), 1, 0).on(clean);
  EXPECT_LE((shown - clean).cwiseAbs().maxCoeff(), 0.125 + 1e-12);
  EXPECT_TRUE(((4.0 * shown).array().round() == (4.0 * shown).array()).all());
}

TEST(MeasurementNoise, NoneLeavesTheOutputsAlone) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Random(2, 10);
  EXPECT_EQ(MeasurementNoise({}, 1, 1).on(clean), clean);
}

TEST(MeasurementNoise, FirstDrawsStayAsTheyAre) {
  // Computed apart, from the published recurrences of SplitMix64 and MT19937-64: a change here changes all results.
  MeasurementNoise uniform({NoiseKind::kUniform, 1.0}, 1, 0);
  const double a = uniform.draw(), b = uniform.draw();
  EXPECT_EQ(a, -0.11701665110749704);
  EXPECT_EQ(b, -0.34319542556475);
}

}  // namespace
}  // namespace nlo::trainer
