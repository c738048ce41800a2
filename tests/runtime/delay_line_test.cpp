// SPDX-License-Identifier: MIT
// The delay of inputs in a delay line: closed forms, and the values before the first sample.
#include <nlo/delay_line.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <type_traits>
#include <utility>

namespace nlo {
namespace {

// Linear interpolation between samples of sin(w k) errs by at most w^2 / 8.
constexpr double kFrequency = 0.1, kChord = kFrequency * kFrequency / 8.0;

TEST(DelayLine, DelaysARampByAFractionExactly) {
  DelayLine<2, 5, double> line({2.25, 5.0});
  for (int k = 0; k < 40; ++k) {
    const auto u = line.push({{0.5 * k, -2.0 * k}});
    if (k < 6) continue;  // the line is not full yet
    EXPECT_DOUBLE_EQ(u[0], 0.5 * (k - 2.25)) << k;
    EXPECT_DOUBLE_EQ(u[1], -2.0 * (k - 5.0)) << k;
  }
}

TEST(DelayLine, DelaysASinusoidWithinTheErrorOfLinearInterpolation) {
  for (const double delay : {0.0, 0.5, 1.7, 2.999, 3.0}) {
    DelayLine<1, 3, double> line({delay});
    double worst = 0.0, worst_undelayed = 0.0;
    for (int k = 0; k < 200; ++k) {
      const double now = std::sin(kFrequency * k), u = line.push({{now}})[0];
      if (k < 4) continue;
      worst = std::max(worst, std::abs(u - std::sin(kFrequency * (k - delay))));
      worst_undelayed = std::max(worst_undelayed, std::abs(u - now));
    }
    EXPECT_LE(worst, kChord * 1.001) << delay;
    if (delay > 0.0) {
      EXPECT_GT(worst_undelayed, 10.0 * kChord) << delay;  // control: without the delay the signal differs
    }
  }
}

TEST(DelayLine, HoldsTheFirstInputUntilItIsFullAndAfterAReset) {
  DelayLine<1, 3> line({2.5F});
  EXPECT_EQ(line.push({{4.0F}})[0], 4.0F);
  EXPECT_EQ(line.push({{8.0F}})[0], 4.0F);
  EXPECT_EQ(line.push({{0.0F}})[0], 4.0F);
  EXPECT_EQ(line.push({{0.0F}})[0], 6.0F);  // half of 8, half of 4
  line.reset();
  EXPECT_EQ(line.push({{-1.0F}})[0], -1.0F);
  EXPECT_EQ(line.push({{5.0F}})[0], -1.0F);
}

TEST(DelayLine, AFaultIsReportedWhenItsInputActs) {
  DelayLine<1, 3> line({2.0F});
  for (int k = 0; k < 5; ++k) (void)line.push({{1.0F}});
  EXPECT_EQ(line.push({{std::numeric_limits<float>::quiet_NaN()}})[0], 1.0F);
  EXPECT_EQ(line.push({{1.0F}})[0], 1.0F);
  EXPECT_FALSE(is_finite(line.push({{1.0F}})[0]));
  EXPECT_EQ(line.push({{1.0F}})[0], 1.0F);
}

TEST(DelayLine, ADelaySetAtRunTimeIsLimitedToTheLine) {
  const double not_a_number = std::numeric_limits<double>::quiet_NaN();
  for (const auto& [asked, used] : {std::pair{-1.0, 0.0}, {7.5, 3.0}, {1e300, 3.0}, {not_a_number, 0.0}}) {
    DelayLine<1, 3, double> line({asked});
    double u = 0.0;
    for (int k = 0; k < 9; ++k) u = line.push({{1.0 * k}})[0];
    EXPECT_EQ(u, 8.0 - used) << asked;
  }
}

TEST(DelayLine, CanBeEvaluatedAtCompileTime) {
  static constinit DelayLine<1, 2> line({1.0F});
  EXPECT_EQ(line.push({{3.0F}})[0], 3.0F);
  constexpr float kActing = [] {
    DelayLine<1, 2> own({0.5F});
    (void)own.push({{0.0F}});
    return own.push({{2.0F}})[0];
  }();
  static_assert(kActing == 1.0F);
}

template <int kDelay>
concept IsAConstant = requires {
  typename std::bool_constant<(DelayLine<1, 2>({static_cast<float>(kDelay)}), true)>;
};
static_assert(IsAConstant<0> && IsAConstant<2> && !IsAConstant<3> && !IsAConstant<-1>, "outside does not compile");

TEST(DelayLine, AcceptsBothEndsOfItsRange) {
  static constinit DelayLine<2, 2> line({0.0F, 2.0F});
  for (int k = 0; k < 5; ++k) (void)line.push({{1.0F * static_cast<float>(k), 1.0F * static_cast<float>(k)}});
  const auto acting = line.push({{5.0F, 5.0F}});
  EXPECT_EQ(acting[0], 5.0F);
  EXPECT_EQ(acting[1], 3.0F);
}

}  // namespace
}  // namespace nlo
