// SPDX-License-Identifier: MIT
#include "trainer/noise.h"

#include <gtest/gtest.h>

#include "codegen/error.h"

namespace nlo::trainer {
namespace {

TEST(Noise, ReadsItsThreeForms) {
  EXPECT_EQ(parse_noise("none"), (NoiseConfig{NoiseKind::kNone, 0.0}));
  EXPECT_EQ(parse_noise("gaussian:0.5"), (NoiseConfig{NoiseKind::kGaussian, 0.5}));
  EXPECT_EQ(parse_noise("uniform:3"), (NoiseConfig{NoiseKind::kUniform, 3.0}));
}

TEST(Noise, FormatReadsBackToTheSameValue) {
  for (const char* text : {"none", "gaussian:0.5", "uniform:3", "gaussian:1e-06", "uniform:0.1"})
    EXPECT_EQ(format_noise(parse_noise(text)), text);
}

TEST(Noise, RefusesEverythingElse) {
  for (const char* text : {"", "None", "gaussian", "gaussian:", "gaussian:x", "gaussian:-1", "gaussian:nan",
                           "gaussian:inf", "gaussian:0.5x", "gaussian:0,5", "uniform:3:4", "laplace:1", ":1"})
    EXPECT_THROW(parse_noise(text), codegen::Error) << text;
}

}  // namespace
}  // namespace nlo::trainer
