// SPDX-License-Identifier: MIT
#include "trainer/base/interpolate.h"

#include <gtest/gtest.h>

#include <cmath>

namespace nlo::trainer {
namespace {

constexpr double kPerSample = 2.0 * 3.14159265358979 / 20.0;
constexpr std::ptrdiff_t kCount = 60;

double wave(std::ptrdiff_t k) {
  return std::sin(kPerSample * static_cast<double>(k));
}

TEST(Interpolate, HasTheErrorsThatItsCommentsState) {
  double line = 0.0, cubic = 0.0;
  for (double at = 3.0; at < 50.0; at += 0.125) {
    line = std::max(line, std::abs(linear_at<double>(wave, kCount, at) - std::sin(kPerSample * at)));
    cubic = std::max(cubic, std::abs(cubic_at<double>(wave, kCount, at) - std::sin(kPerSample * at)));
  }
  EXPECT_NEAR(line, 1.2e-2, 1e-3);
  EXPECT_LT(cubic, 3e-4);
  EXPECT_GT(cubic, 1e-4);
}

TEST(Interpolate, IsExactAtSamplesAndHeldBeyondTheEnds) {
  for (const double at : {0.0, 1.0, 17.0, 59.0}) {
    EXPECT_EQ(linear_at<double>(wave, kCount, at), wave(static_cast<std::ptrdiff_t>(at)));
    EXPECT_EQ(cubic_at<double>(wave, kCount, at), wave(static_cast<std::ptrdiff_t>(at)));
  }
  EXPECT_EQ(cubic_at<double>(wave, kCount, -3.5), wave(0));
  EXPECT_EQ(linear_at<double>(wave, kCount, 70.2), wave(59));
  const auto cube = [](std::ptrdiff_t k) { return static_cast<double>(k * k * k); };
  EXPECT_NEAR(cubic_at<double>(cube, kCount, 10.3), 10.3 * 10.3 * 10.3, 1e-9);
}

}  // namespace
}  // namespace nlo::trainer
