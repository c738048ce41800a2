// SPDX-License-Identifier: MIT
#include "trainer/data/measurement_noise.h"

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

TEST(MeasurementNoise, OtherSeedsAndRunsAreUncorrelated) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Zero(1, 1000);
  const Eigen::MatrixXd one = MeasurementNoise(kGaussian, 5, 9).on(clean);
  // Seed 5 run 9, and pairs that a simple seed + run could not distinguish.
  for (const auto& [seed, run] : {std::pair{6, 8}, {5, 10}, {9, 5}, {14, 0}}) {
    const Eigen::MatrixXd other =
        MeasurementNoise(kGaussian, static_cast<std::uint64_t>(seed), static_cast<std::uint64_t>(run)).on(clean);
    const double correlation = one.cwiseProduct(other).sum() / (one.norm() * other.norm());
    EXPECT_LT(std::abs(correlation), 5.0 / std::sqrt(1000.0)) << seed << " " << run;
  }
}

TEST(MeasurementNoise, IsIndependentForEachSensor) {
  const NoiseConfig noise = parse_noise("gaussian:0.5,none,uniform:3");
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Constant(3, 5000, 2.0);
  const Eigen::MatrixXd v = MeasurementNoise(noise, 3, 0).on(clean) - clean;
  // Four standard errors of a deviation from 5,000 draws, each 1 %.
  EXPECT_NEAR(std::sqrt(v.row(0).squaredNorm() / 5000.0), 0.5, 0.02);
  EXPECT_TRUE((v.row(1).array() == 0.0).all());
  EXPECT_NEAR(std::sqrt(v.row(2).squaredNorm() / 5000.0), std::sqrt(3.0), 0.07);
  EXPECT_LE(v.row(2).cwiseAbs().maxCoeff(), 3.0);
  EXPECT_EQ(noise_variances(noise), Eigen::Vector3d(0.25, 0.0, 3.0));
  EXPECT_EQ(noise_title(noise), "N(0, 0.5), no noise, U(-3, 3)");
}

TEST(MeasurementNoise, IsAddedToTheAngleNotToItsSine) {
  constexpr Eigen::Index kSamples = 100;
  constexpr double kDegree = 3.141592653589793 / 180.0;
  const Eigen::RowVectorXd angle = Eigen::RowVectorXd::LinSpaced(kSamples, -400.0, 400.0);
  Eigen::MatrixXd plain(2, kSamples), encoded(3, kSamples);
  plain << angle, angle;
  encoded << (kDegree * angle.array()).sin(), (kDegree * angle.array()).cos(), angle;
  const NoiseConfig noise{NoiseKind::kGaussian, 20.0};
  const Eigen::MatrixXd expected = MeasurementNoise(noise, 3, 0).on(plain);
  const Eigen::MatrixXd measured = MeasurementNoise(noise, 3, 0).on(encoded, {{0, 360.0}});
  // The draws are equal, so these are the sine and cosine of the angle that a sensor without encoding shows.
  EXPECT_LE((measured.row(0).array() - (kDegree * expected.row(0).array()).sin()).abs().maxCoeff(), 1e-13);
  EXPECT_LE((measured.row(1).array() - (kDegree * expected.row(0).array()).cos()).abs().maxCoeff(), 1e-13);
  EXPECT_EQ(measured.row(2), expected.row(1));
}

TEST(MeasurementNoise, ClipsAndRoundsTheAngleNotItsSine) {
  constexpr double kDegree = 3.141592653589793 / 180.0;
  const Eigen::RowVectorXd angle = Eigen::RowVectorXd::LinSpaced(100, -160.0, 160.0);  // with noise within half a turn
  Eigen::MatrixXd encoded(2, 100);
  encoded << (kDegree * angle.array()).sin(), (kDegree * angle.array()).cos();
  const NoiseConfig noise = parse_noise("uniform:5+clipped:90+quantised:10");
  const Eigen::MatrixXd expected = kDegree * MeasurementNoise(noise, 3, 0).on(angle);
  EXPECT_GT(expected.maxCoeff(), 80.0 * kDegree);
  const Eigen::MatrixXd measured = MeasurementNoise(noise, 3, 0).on(encoded, {{0, 360.0}});
  EXPECT_LE((measured.row(0).array() - expected.array().sin()).abs().maxCoeff(), 1e-13);
  EXPECT_LE((measured.row(1).array() - expected.array().cos()).abs().maxCoeff(), 1e-13);
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

TEST(MeasurementNoise, OutliersHaveTheirShareAndABiasIsConstantInARun) {
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

TEST(MeasurementNoise, NoneLeavesTheOutputsUnchanged) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Random(2, 10);
  EXPECT_EQ(MeasurementNoise({}, 1, 1).on(clean), clean);
}

TEST(MeasurementNoise, FirstDrawsNeverChange) {
  // Computed separately from the published recurrences of SplitMix64 and MT19937-64. A change here changes all results.
  MeasurementNoise uniform({NoiseKind::kUniform, 1.0}, 1, 0);
  const double a = uniform.draw(), b = uniform.draw();
  EXPECT_EQ(a, -0.11701665110749704);
  EXPECT_EQ(b, -0.34319542556475);
}

/// y(k) = k.
Eigen::MatrixXd ramp(Eigen::Index outputs, Eigen::Index samples) {
  return Eigen::RowVectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1)).replicate(outputs, 1);
}

TEST(MeasurementNoise, DelaysByTheDeclaredTime) {
  constexpr double kPerSample = 0.25;
  const Eigen::MatrixXd clean = (kPerSample * ramp(1, 400).array()).sin();
  const Eigen::MatrixXd late = MeasurementNoise(parse_noise("none+delay:2.5"), 1, 0).on(clean);
  for (Eigen::Index k = 5; k < 400; ++k)
    ASSERT_NEAR(late(0, k), std::sin(kPerSample * (static_cast<double>(k) - 2.5)), 2e-4) << k;
  EXPECT_EQ(late(0, 2), clean(0, 0));
  const Eigen::MatrixXd drawn = MeasurementNoise(parse_noise("none+delay:1:3,none"), 1, 0).on(ramp(2, 50));
  const double delay = 30.0 - drawn(0, 30);
  EXPECT_GT(delay, 1.0);
  EXPECT_LT(delay, 3.0);
  EXPECT_NEAR(40.0 - drawn(0, 40), delay, 1e-12);
  EXPECT_EQ(drawn.row(1), ramp(1, 50));
}

TEST(MeasurementNoise, JitterIsUniformAndCommonToAllSensors) {
  constexpr Eigen::Index kSamples = 20'000;
  const Eigen::MatrixXd y = MeasurementNoise(parse_noise("none+jitter:0.4"), 3, 0).on(ramp(2, kSamples));
  EXPECT_EQ(y.row(0), y.row(1));
  const Eigen::ArrayXd off = (y - ramp(2, kSamples)).row(0).segment(1, kSamples - 2).transpose();
  EXPECT_LE(off.abs().maxCoeff(), 0.4 + 1e-9);
  EXPECT_NEAR(off.mean(), 0.0, 5.0 * 0.4 / std::sqrt(3.0 * kSamples));
  EXPECT_NEAR(off.square().mean() / 0.16, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / kSamples));
}

TEST(MeasurementNoise, MissingSamplesAreNanAndHeldAtTheLastValue) {
  constexpr Eigen::Index kSamples = 40'000;
  const Eigen::MatrixXd y = MeasurementNoise(parse_noise("none+missing:0.1:4,none"), 3, 0).on(ramp(2, kSamples));
  const auto missing = y.row(0).array().isNaN();
  EXPECT_FALSE(missing(0));
  // 1,000 bursts whose lengths have a standard deviation of 3.5: five standard errors.
  EXPECT_NEAR(missing.cast<double>().mean(), 0.1, 0.02);
  double bursts = 0.0;
  for (Eigen::Index k = 1; k < kSamples; ++k) bursts += missing(k) && !missing(k - 1) ? 1.0 : 0.0;
  EXPECT_NEAR(missing.cast<double>().sum() / bursts, 4.0, 0.6);
  EXPECT_EQ(y.row(1), ramp(1, kSamples));
  const Eigen::MatrixXd filled = held(y);
  for (Eigen::Index k = 1; k < kSamples; ++k) ASSERT_EQ(filled(0, k), missing(k) ? filled(0, k - 1) : y(0, k));
}

TEST(MeasurementNoise, AStuckSensorRepeatsItsValueAndADeadSensorReadsZeroAndNeitherIsMarkedMissing) {
  constexpr Eigen::Index kSamples = 40'000;
  const Eigen::MatrixXd clean = ramp(2, kSamples).array() + 1.0;
  const Eigen::MatrixXd y = MeasurementNoise(parse_noise("none+stuck:0.1:4,none+dead:0.1:4"), 3, 0).on(clean);
  double out[2] = {};
  for (Eigen::Index k = 1; k < kSamples; ++k)
    for (Eigen::Index row = 0; row < 2; ++row) {
      if (y(row, k) == clean(row, k)) continue;
      ASSERT_EQ(y(row, k), row == 0 ? y(0, k - 1) : 0.0);
      out[row] += 1.0;
    }
  for (const double count : out) EXPECT_NEAR(count / kSamples, 0.1, 0.02) << "five standard errors, as above";

  constexpr double kPi = 3.14159265358979323;
  const Eigen::MatrixXd angle = MeasurementNoise(parse_noise("none+dead:0.5:4"), 3, 0)
                                    .on(Eigen::Vector2d(1.0, 0.0).replicate(1, 100), {{0, 2.0 * kPi}});
  for (Eigen::Index k = 0; k < 100; ++k) ASSERT_EQ(angle.col(k).norm(), 1.0) << "an angle of 0: sine 0, cosine 1";
  EXPECT_GT(angle.row(1).sum(), 20.0);
}

TEST(MeasurementNoise, ABiasCanBeCommonToSensorsAndReadingsCanBeClipped) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Ones(2, 50);
  const auto on = [&](const std::string& noise, std::uint64_t run) {
    return MeasurementNoise(parse_noise(noise), 3, run).on(clean);
  };
  const Eigen::MatrixXd y = on("none+common_bias:0.4,none+common_bias:0.2", 0);
  EXPECT_NEAR((y(0, 0) - 1.0) / (y(1, 0) - 1.0), 2.0, 1e-9) << "one draw, scaled for each sensor";
  EXPECT_EQ(y(0, 0), y(0, 49));
  EXPECT_NE(y(0, 0), on("none+common_bias:0.4,none+common_bias:0.2", 1)(0, 0));
  EXPECT_EQ(on("none+clipped:0.25", 0), 0.25 * clean);
}

TEST(MeasurementNoise, TimingFaultsDoNotChangeTheRandomNumbers) {
  const Eigen::MatrixXd clean = Eigen::MatrixXd::Ones(2, 300);
  const Eigen::MatrixXd off =
      MeasurementNoise(parse_noise("gaussian:0.5+outliers:0.1:4"), 5, 9).on(clean) -
      MeasurementNoise(parse_noise("gaussian:0.5+outliers:0.1:4+delay:1:3+jitter:0.3"), 5, 9).on(clean);
  EXPECT_LE(off.cwiseAbs().maxCoeff(), 1e-12) << "equal except for rounding of the interpolation";
  const Eigen::MatrixXd lossy = MeasurementNoise(parse_noise("gaussian:0.5+missing:0.3"), 5, 9).on(clean);
  const Eigen::MatrixXd full = MeasurementNoise(parse_noise("gaussian:0.5"), 5, 9).on(clean);
  EXPECT_TRUE((lossy.array().isNaN() || lossy.array() == full.array()).all());
}

TEST(MeasurementNoise, SineAndCosineOfAnAngleAreDelayedAndMissingTogether) {
  constexpr double kPi = 3.14159265358979323, kCubic = 1e-6;
  const Eigen::ArrayXd angle = 0.1 * ramp(1, 200).transpose().array();
  Eigen::MatrixXd clean(2, 200);
  clean << angle.sin().matrix().transpose(), angle.cos().matrix().transpose();
  const Eigen::MatrixXd y =
      MeasurementNoise(parse_noise("none+delay:2.5+missing:0.2"), 1, 0).on(clean, {{0, 2.0 * kPi}});
  for (Eigen::Index k = 5; k < 199; ++k) {
    ASSERT_EQ(std::isnan(y(0, k)), std::isnan(y(1, k)));
    if (std::isnan(y(0, k))) continue;
    ASSERT_NEAR(std::remainder(std::atan2(y(0, k), y(1, k)) - angle(k) + 0.25, 2.0 * kPi), 0.0, kCubic);
  }
}

}  // namespace
}  // namespace nlo::trainer
