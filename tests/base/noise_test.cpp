// SPDX-License-Identifier: MIT
// Properties of each kind of noise in the table of noises.
#include "trainer/base/noise.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "codegen/base/error.h"
#include "tests/support/thrown_message.h"
#include "trainer/base/noise_table.h"
#include "trainer/base/random.h"

namespace nlo::trainer {
namespace {

TEST(Noise, ReadsOutliersBiasClippingAndQuantisation) {
  const SensorNoise noise = parse_noise("student:0.5:3+outliers:0.05:10+bias:0.2+quantised:0.25").of(0);
  EXPECT_EQ(noise.kind, NoiseKind::kStudent);
  EXPECT_EQ(noise.scale, 0.5);
  EXPECT_EQ(noise.shape, 3);
  EXPECT_EQ(noise.outlier_share, 0.05);
  EXPECT_EQ(noise.outlier_amplitude, 10.0);
  EXPECT_EQ(noise.bias, 0.2);
  EXPECT_EQ(noise.quantum, 0.25);
  EXPECT_FALSE(parse_noise("none+bias:0.1").none());
  EXPECT_TRUE(parse_noise("none+bias:0").none());
}

TEST(Noise, ReadsDelayAndJitter) {
  const SensorNoise noise = parse_noise("none+delay:1.5:2+jitter:0.2+missing:0.05:4").of(0);
  EXPECT_EQ(noise.delay_low, 1.5);
  EXPECT_EQ(noise.delay_high, 2.0);
  EXPECT_EQ(noise.jitter, 0.2);
  EXPECT_EQ(noise.outage(OutageKind::kMissing), (OutageRate{0.05, 4.0}));
  EXPECT_FALSE(noise.none());
  EXPECT_FALSE(noise.disturbed());
  EXPECT_TRUE(parse_noise("none+delay:0+missing:0").none());
  EXPECT_EQ(parse_noise("none+delay:3").of(0).delay_low, 3.0);
}

TEST(Noise, ReadsMissingStuckAndDeadSamples) {
  const std::string text = "none+common_bias:0.3+clipped:2+stuck:0.02:50+dead:0.01";
  const SensorNoise noise = parse_noise(text).of(0);
  EXPECT_EQ(noise.common_bias, 0.3);
  EXPECT_EQ(noise.limit, 2.0);
  EXPECT_EQ(noise.outage(OutageKind::kStuck), (OutageRate{0.02, 50.0}));
  EXPECT_EQ(noise.outage(OutageKind::kDead), (OutageRate{0.01, 0.0}));
  EXPECT_EQ(format_noise(noise), text);
  EXPECT_TRUE(noise.lies() && noise.disturbed());
  EXPECT_FALSE(parse_noise("none+missing:0.1").of(0).lies()) << "the observer knows that the sample is missing";
  EXPECT_THROW(parse_noise("none+stuck:1"), codegen::Error);
  EXPECT_THROW(parse_noise("none+dead:0.5:0.5"), codegen::Error);
}

TEST(Noise, BurstsOfMissingSamplesAddUpToTheirShare) {
  const OutageOdds rates = outage_odds({0.2, 5.0});
  EXPECT_NEAR(rates.begins / (rates.begins + 1.0 - rates.goes_on), 0.2, 1e-12) << "stationary share of missing samples";
  EXPECT_NEAR(1.0 / (1.0 - rates.goes_on), 5.0, 1e-12);
  EXPECT_EQ(outage_odds({0.2, 0.0}).goes_on, 0.2) << "samples are missing independently";
}

TEST(Noise, RefusesImpossibleTimes) {
  for (const auto& [text, why] : {std::pair{"none+delay:3:1", "minimum delay above its maximum"},
                                  {"none+delay", "has no scale"},
                                  {"none+delay:20000", "above 10000 samples"},
                                  {"none+delay:1:2:3", "one number too many"},
                                  {"none+jitter:0.6", "above half a sample period"},
                                  {"none+missing:1", "all samples missing"},
                                  {"none+missing:0.5:0.5", "less than one sample"},
                                  {"none+missing:0.8:2", "bursts of this length"}}) {
    EXPECT_THAT(thrown_message([refused = text] { parse_noise(refused); }), testing::HasSubstr(why));
  }
}

TEST(Noise, ReadsItsThreeNotations) {
  EXPECT_EQ(parse_noise("none"), (NoiseConfig{NoiseKind::kNone, 0.0}));
  EXPECT_EQ(parse_noise("gaussian:0.5"), (NoiseConfig{NoiseKind::kGaussian, 0.5}));
  EXPECT_EQ(parse_noise("uniform:3"), (NoiseConfig{NoiseKind::kUniform, 3.0}));
}

TEST(Noise, ReadsOneForEachOutput) {
  const NoiseConfig noise = parse_noise("gaussian:0.1,none,uniform:0.02");
  ASSERT_EQ(noise.sensors.size(), 3u);
  EXPECT_EQ(noise.of(0), (SensorNoise{NoiseKind::kGaussian, 0.1}));
  EXPECT_EQ(noise.of(1), SensorNoise{});
  EXPECT_EQ(noise.of(2), (SensorNoise{NoiseKind::kUniform, 0.02}));
  EXPECT_FALSE(noise.none());
  EXPECT_TRUE(parse_noise("none,none").none());
  EXPECT_EQ(parse_noise("uniform:3").of(5), (SensorNoise{NoiseKind::kUniform, 3.0}))
      << "a single noise applies to all outputs";
}

TEST(Noise, MustHaveOneForAllOutputsOrOneForEach) {
  EXPECT_NO_THROW(check_noise(parse_noise("gaussian:1"), 3));
  EXPECT_NO_THROW(check_noise(parse_noise("gaussian:1,none,none"), 3));
  EXPECT_THROW(check_noise(parse_noise("gaussian:1,none"), 3), codegen::Error);
  EXPECT_THROW(check_noise(parse_noise("gaussian:1,none"), 1), codegen::Error);
}

TEST(Noise, FormatReadsBackToTheSameValue) {
  for (const char* text :
       {"none", "gaussian:0.5", "uniform:3", "gaussian:1e-06", "uniform:0.1", "gaussian:0.1,none", "none,none",
        "student:0.5:2", "gaussian:0.5+outliers:0.05:10+bias:0.2+quantised:0.25", "none+quantised:1",
        "gaussian:0.5+delay:1.5+jitter:0.2+missing:0.05:4", "none+delay:1:3", "none+missing:0.1,none"})
    EXPECT_EQ(format_noise(parse_noise(text)), text);
}

TEST(Noise, RefusesMalformedTexts) {
  for (const char* text : {"",
                           "None",
                           "gaussian",
                           "gaussian:",
                           "gaussian:x",
                           "gaussian:-1",
                           "gaussian:nan",
                           "gaussian:inf",
                           "gaussian:0.5x",
                           "gaussian:0,5",
                           "uniform:3:4",
                           "laplace:1",
                           ":1",
                           ",",
                           "none,",
                           ",none",
                           "gaussian:1,,none",
                           "student:1",
                           "student:1:0",
                           "student:1:2.5",
                           "student:1:99",
                           "gaussian:1:2",
                           "none:1",
                           "gaussian:1+",
                           "+bias:1",
                           "gaussian:1+bias",
                           "gaussian:1+bias:1:2",
                           "gaussian:1+outliers:2:1",
                           "gaussian:1+drift:1"})
    EXPECT_THROW(parse_noise(text), codegen::Error) << text;
}

constexpr int kDraws = 100'000;

class Scalars final : public NoiseNumbers<double> {
 public:
  double uniform() override { return std::uniform_real_distribution<>(-1.0, 1.0)(engine_); }
  double normal() override { return normal_(engine_); }
  void normals(std::span<double> all) override {
    for (double& each : all) each = normal();
  }

 private:
  std::mt19937_64 engine_{3};
  std::normal_distribution<> normal_;
};

class Lanes final : public NoiseNumbers<LaneValue> {
 public:
  LaneValue uniform() override {
    return LaneValue::NullaryExpr([&] { return static_cast<float>(scalars_.uniform()); });
  }
  LaneValue normal() override {
    return LaneValue::NullaryExpr([&] { return static_cast<float>(scalars_.normal()); });
  }
  void normals(std::span<LaneValue> all) override {
    for (LaneValue& each : all) each = normal();
  }

 private:
  Scalars scalars_;
};

/// Integral of the density over |v| < reach, by the midpoint rule.
double mass(const NoiseRow& row, double reach, int shape) {
  constexpr int kPoints = 20'000;
  const double step = 2.0 * reach / kPoints;
  const Eigen::ArrayXd v = Eigen::ArrayXd::LinSpaced(kPoints, -reach + 0.5 * step, reach - 0.5 * step);
  return row.density(v, shape).sum() * step;
}

class EveryNoise : public ::testing::TestWithParam<std::string> {
 protected:
  const NoiseRow& row() const { return *std::ranges::find(noise_table(), GetParam(), &NoiseRow::name); }
  int shape() const { return row().has_shape() ? std::min(5, row().most_shape) : 0; }
};

TEST_P(EveryNoise, TextReadsBackToTheSameNoise) {
  const std::string text =
      GetParam() + (row().has_scale() ? ":0.5" : "") + (row().has_shape() ? ":" + std::to_string(shape()) : "");
  const NoiseConfig noise = parse_noise(text);
  EXPECT_EQ(noise.of(0).kind, row().kind);
  EXPECT_EQ(format_noise(noise), text);
  EXPECT_EQ(&noise_row(noise.of(0).kind), &row());
  EXPECT_FALSE(row().title(noise.of(0)).empty());
  EXPECT_EQ(noise.of(0).has_tails(), row().tails);
}

/// Tolerance 0.5 %: five standard errors of a share of 1e5 draws, plus the width of a bin at the edge of a uniform
/// density.
TEST_P(EveryNoise, DrawsFollowTheDensityOneByOneAndInLanesOfEight) {
  if (row().density == nullptr) return;
  EXPECT_NEAR(mass(row(), 200.0, shape()), 1.0, 5e-3);
  Scalars one;
  Lanes eight;
  for (const double reach : {0.3, 0.7, 2.0}) {
    int inside = 0, inside_lanes = 0;
    for (int i = 0; i < kDraws; ++i) inside += std::abs(row().draw(one, shape())) < reach;
    for (int i = 0; i < kDraws / kNoiseLanes; ++i)
      inside_lanes += static_cast<int>((row().draw_lanes(eight, shape()).abs() < static_cast<float>(reach)).count());
    EXPECT_NEAR(inside / double{kDraws}, mass(row(), reach, shape()), 8e-3) << reach;
    EXPECT_NEAR(inside_lanes / double{kDraws}, mass(row(), reach, shape()), 8e-3) << reach;
  }
}

TEST_P(EveryNoise, HasTheVarianceAndTheLimitOfItsTableRow) {
  Scalars one;
  double squares = 0.0, largest = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double v = row().draw(one, row().has_shape() ? row().most_shape : 0);
    squares += v * v;
    largest = std::max(largest, std::abs(v));
  }
  EXPECT_LE(largest, row().largest);
  EXPECT_EQ(row().bounded(), largest <= 1.0) << "of 1e5 draws of unbounded noise, some exceed its scale";
  if (row().tails) return;  // only its nominal variance is known
  EXPECT_NEAR(squares / kDraws, row().variance, 0.03 * row().variance) << "3 % is more than five standard errors";
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const NoiseRow& row : noise_table()) all.emplace_back(row.name);
  return all;
}
INSTANTIATE_TEST_SUITE_P(Table, EveryNoise, ::testing::ValuesIn(names()), [](const auto& each) { return each.param; });

}  // namespace
}  // namespace nlo::trainer
