// SPDX-License-Identifier: MIT
#include "trainer/base/noise.h"

#include <gtest/gtest.h>

#include "codegen/base/error.h"

namespace nlo::trainer {
namespace {

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
       {"none", "gaussian:0.5", "uniform:3", "gaussian:1e-06", "uniform:0.1", "gaussian:0.1,none", "none,none"})
    EXPECT_EQ(format_noise(parse_noise(text)), text);
}

TEST(Noise, RefusesEverythingElse) {
  for (const char* text :
       {"", "None", "gaussian", "gaussian:", "gaussian:x", "gaussian:-1", "gaussian:nan", "gaussian:inf",
        "gaussian:0.5x", "gaussian:0,5", "uniform:3:4", "laplace:1", ":1", ",", "none,", ",none", "gaussian:1,,none"})
    EXPECT_THROW(parse_noise(text), codegen::Error) << text;
}

}  // namespace
}  // namespace nlo::trainer
