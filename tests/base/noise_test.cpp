// SPDX-License-Identifier: MIT
#include "trainer/base/noise.h"

#include <gtest/gtest.h>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

TEST(Noise, ReadsWhatElseASensorDoes) {
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

TEST(Noise, ReadsWhenASensorMeasures) {
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

TEST(Noise, ReadsHowASensorLies) {
  const std::string text = "none+common_bias:0.3+clipped:2+stuck:0.02:50+dead:0.01";
  const SensorNoise noise = parse_noise(text).of(0);
  EXPECT_EQ(noise.common_bias, 0.3);
  EXPECT_EQ(noise.limit, 2.0);
  EXPECT_EQ(noise.outage(OutageKind::kStuck), (OutageRate{0.02, 50.0}));
  EXPECT_EQ(noise.outage(OutageKind::kDead), (OutageRate{0.01, 0.0}));
  EXPECT_EQ(format_noise(noise), text);
  EXPECT_TRUE(noise.lies() && noise.disturbed());
  EXPECT_FALSE(parse_noise("none+missing:0.1").of(0).lies()) << "the observer is told";
  EXPECT_THROW(parse_noise("none+stuck:1"), codegen::Error);
  EXPECT_THROW(parse_noise("none+dead:0.5:0.5"), codegen::Error);
}

TEST(Noise, BurstsOfMissingSamplesAddUpToTheirShare) {
  const OutageOdds rates = outage_odds({0.2, 5.0});
  EXPECT_NEAR(rates.begins / (rates.begins + 1.0 - rates.goes_on), 0.2, 1e-12) << "what the chain settles at";
  EXPECT_NEAR(1.0 / (1.0 - rates.goes_on), 5.0, 1e-12);
  EXPECT_EQ(outage_odds({0.2, 0.0}).goes_on, 0.2) << "each sample by itself";
}

TEST(Noise, RefusesTimesThatCannotBe) {
  for (const auto& [text, why] : {std::pair{"none+delay:3:1", "least is above its most"},
                                  {"none+delay", "has no scale"},
                                  {"none+delay:20000", "above 10000 samples"},
                                  {"none+delay:1:2:3", "one number too many"},
                                  {"none+jitter:0.6", "above half a sample period"},
                                  {"none+missing:1", "all samples missing"},
                                  {"none+missing:0.5:0.5", "less than one sample"},
                                  {"none+missing:0.8:2", "bursts that short"}}) {
    try {
      parse_noise(text);
      FAIL() << text;
    } catch (const codegen::Error& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  }
}

TEST(Noise, ReadsItsThreeForms) {
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
  EXPECT_EQ(parse_noise("uniform:3").of(5), (SensorNoise{NoiseKind::kUniform, 3.0})) << "one is for all outputs";
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

TEST(Noise, RefusesEverythingElse) {
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

}  // namespace
}  // namespace nlo::trainer
