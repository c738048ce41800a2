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
  EXPECT_EQ(noise.freedom, 3);
  EXPECT_EQ(noise.outlier_share, 0.05);
  EXPECT_EQ(noise.outlier_amplitude, 10.0);
  EXPECT_EQ(noise.bias, 0.2);
  EXPECT_EQ(noise.quantum, 0.25);
  EXPECT_FALSE(parse_noise("none+bias:0.1").none());
  EXPECT_TRUE(parse_noise("none+bias:0").none());
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
        "student:0.5:2", "gaussian:0.5+outliers:0.05:10+bias:0.2+quantised:0.25", "none+quantised:1"})
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
