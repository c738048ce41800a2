// SPDX-License-Identifier: MIT
// Angles: a shaft may turn any number of times; whole turns are subtracted from z as well, and the estimate does not
// change.
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/runtime/testing.h"

namespace nlo {
namespace {

using testing::angle_model;
using testing::kPi;

template <class Scalar>
using Observer = KklObserver<testing::AngleModel<Scalar>>;

/// The angle as an encoder reports it, within [low, low + 2 pi].
double measured(double angle, double low) {
  return angle - 2 * kPi * std::floor((angle - low) / (2 * kPi));
}

/// A shaft with up to 4 turns a second: 60 turns in one direction, then 120 back, at varying speed, sampled at 250 Hz.
double shaft(int k) {
  const double t = 0.004 * k;
  return 2 * kPi * 60 * std::sin(2 * kPi * t / 100) + 1.3 * std::sin(7 * t);
}
constexpr int kSamples = 25000;

/// Largest difference to the estimate of an observer without wraps that reads the unwrapped angle, in double.
template <class Scalar>
double worst_difference(double low, bool starts_steady, double offset) {
  const auto model = angle_model<Scalar>(low, low + 2 * kPi, starts_steady);
  auto unwrapped_model = angle_model<double>(-1e4, 1e4, starts_steady);
  unwrapped_model.outputs.wrap[0] = 0.0;
  Observer<Scalar> observer(model);
  Observer<double> unwrapped(unwrapped_model);
  double worst = 0.0;
  // The observer starts in its first turn; the unwrapped angle starts there too.
  const double first = measured(shaft(0) + offset, -kPi) - shaft(0) - offset;
  for (int k = 0; k < kSamples; ++k) {
    const double angle = shaft(k) + offset, other = 0.5 * std::sin(0.01 * k);
    EXPECT_EQ(observer.step({{static_cast<Scalar>(measured(angle, low)), static_cast<Scalar>(other)}}),
              StepStatus::kOk);
    EXPECT_EQ(unwrapped.step({{angle + first, other}}), StepStatus::kOk);
    const auto x_hat = observer.estimate();
    const auto expected = unwrapped.estimate();
    for (int i = 0; i < 4; ++i) worst = std::max(worst, std::fabs(static_cast<double>(x_hat[i]) - expected[i]));
  }
  return worst;
}

TEST(Angle, IsNotUnwrappedIfItHasTooManyTurns) {
  const auto turns = [](float angle) {
    const float fast = ReadingRange<float, 1>::whole_turns<Arithmetic::kFast>(angle, 1e-8F);
    EXPECT_EQ(fast, (ReadingRange<float, 1>::whole_turns<Arithmetic::kDeterministic>(angle, 1e-8F))) << angle;
    return fast;
  };
  EXPECT_EQ(turns(10.0F), 1e9F);
  EXPECT_EQ(turns(-10.0F), -1e9F);
  for (const float angle :
       {1e3F, -1e3F, 3e38F, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
    EXPECT_EQ(turns(angle), 0.0F) << angle;
}

TEST(Angle, ManyTurnsGiveTheEstimateOfTheUnwrappedAngle) {
  // |y| <= 2 pi is rounded to 2^-22, then S and the coefficients round: a few such units. In double the unwrapped
  // reference rounds to 2^-44 at 380 rad.
  constexpr double kFloatRounding = 2e-5, kDoubleRounding = 1e-11;
  for (const bool starts_steady : {true, false}) {
    for (const double low : {-kPi, 0.0}) {
      for (const double offset : {0.0, 2.0, 4.5}) {
        EXPECT_LT(worst_difference<float>(low, starts_steady, offset), kFloatRounding) << low << ' ' << offset;
        EXPECT_LT(worst_difference<double>(low, starts_steady, offset), kDoubleRounding) << low << ' ' << offset;
      }
    }
  }
}

TEST(Angle, KeepsItsLatentStateBoundedAndInItsDomain) {
  const auto model = angle_model<float>();
  Observer<float> observer(model);
  float largest = 0.0F;
  for (int k = 0; k < kSamples; ++k) {
    ASSERT_EQ(observer.step({{static_cast<float>(measured(shaft(k), -kPi)), 0.0F}}), StepStatus::kOk);
    for (const float z : observer.latent()) largest = std::max(largest, std::fabs(z));
    ASSERT_LE(std::fabs(observer.save().y[0]), static_cast<float>(kPi) * 1.000001F);
    ASSERT_TRUE(observer.in_domain());
    ASSERT_TRUE(observer.restore(observer.save()));
  }
  EXPECT_LT(largest, 2 * kPi);  // half a turn plus the lag at 4 turns a second
}

TEST(Angle, MayFlickerAtTheWrap) {
  const auto model = angle_model<float>();
  Observer<float> flickering(model), resting(model);
  constexpr float kEdge = static_cast<float>(kPi) - 1e-3F;
  constexpr double kReach = 2.1e-3;  // the flicker moves z by only 2e-3 rad
  for (int k = 0; k < 2000; ++k) {
    ASSERT_EQ(flickering.step({{k % 2 == 0 ? kEdge : -kEdge, 0.0F}}), StepStatus::kOk);
    ASSERT_EQ(resting.step({{kEdge, 0.0F}}), StepStatus::kOk);
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(flickering.estimate()[i], resting.estimate()[i], kReach);
    ASSERT_TRUE(flickering.in_domain());
  }
}

TEST(Angle, MayRestExactlyAtTheWrap) {
  for (const bool starts_steady : {true, false}) {
    const auto model = angle_model<float>(-kPi, kPi, starts_steady);
    for (const float edge : {model.outputs.max[0], model.outputs.min[0]}) {
      Observer<float> observer(model);
      ASSERT_EQ(observer.step({{edge, 0.0F}}), StepStatus::kOk);
      EXPECT_EQ(observer.save().y[0], edge);
      for (int r = 0; r < 3; ++r) {
        EXPECT_FLOAT_EQ(observer.latent()[r], starts_steady ? edge * model.latent.steady_gain[r][0] : 0.0F);
      }
      for (int k = 0; k < 10; ++k) {
        ASSERT_EQ(observer.step({{edge, 0.0F}}), StepStatus::kOk);
        EXPECT_EQ(observer.save().y[0], edge) << "jumps to the other end at step " << k;
      }
    }
  }
}

TEST(Angle, GivesTheSameStartForAllMeasurementsOfTheSameAngle) {
  const auto model = angle_model<double>(-40.0, 40.0, false);
  for (const bool warm : {false, true}) {
    Observer<double> first(model), turned(model);
    ASSERT_EQ(warm ? first.warm_start({{1.0, 0.0}}) : first.step({{1.0, 0.0}}), StepStatus::kOk);
    const Vector<double, 2> three_turns{{1.0 + 6 * kPi, 0.0}};
    ASSERT_EQ(warm ? turned.warm_start(three_turns) : turned.step(three_turns), StepStatus::kOk);
    for (int r = 0; r < 4; ++r) EXPECT_NEAR(first.latent()[r], turned.latent()[r], 1e-14);  // rounding of 20 rad
  }
}

TEST(Angle, GivesTheSameWarmStartAfterAnyNumberOfTurns) {
  const auto model = angle_model<double>();
  Observer<double> fresh(model), used(model);
  ASSERT_EQ(used.warm_start({{3.1, 0.0}}), StepStatus::kOk);
  ASSERT_EQ(used.warm_start({{-3.1, 0.0}}), StepStatus::kOk);  // unwrapped next to 3.1 it would be 3.18
  ASSERT_EQ(fresh.warm_start({{-3.1, 0.0}}), StepStatus::kOk);
  EXPECT_NEAR(used.save().y[0], fresh.save().y[0], 1e-14);
  for (int r = 0; r < 4; ++r) EXPECT_NEAR(used.latent()[r], fresh.latent()[r], 1e-14);
}

TEST(Angle, SurvivesARestartIfItsRangeStartsAtZero) {
  const auto model = angle_model<float>(0.0, 2 * kPi);
  Observer<float> observer(model), restarted(model);
  ASSERT_EQ(observer.step({{6.0F, 0.0F}}), StepStatus::kOk);  // stored as -0.28, outside of [0, 2 pi]
  ASSERT_TRUE(restarted.restore(observer.save()));
  EXPECT_TRUE(testing::same_bits(restarted.save(), observer.save()));
  auto damaged = observer.save();
  damaged.y[0] = -7.0F;
  EXPECT_FALSE(restarted.restore(damaged));
}

TEST(Angle, IsBroughtBackFromAFarTurnTogetherWithZ) {
  const auto model = angle_model<double>(-40.0, 40.0);
  Observer<double> near(model), far(model);
  const double turn = model.outputs.wrap[0];
  Vector<double, 4> z_near{{1.1, 0.2, 0.9, 0.3}}, z_far = z_near;
  for (int r = 0; r < 4; ++r) z_far[r] += 5 * turn * model.latent.steady_gain[r][0];
  ASSERT_TRUE(near.reset(z_near, {{1.0, 0.5}}));
  ASSERT_TRUE(far.reset(z_far, {{1.0 + 5 * turn, 0.5}}));
  ASSERT_EQ(near.step({{1.25, 0.5}}), StepStatus::kOk);
  ASSERT_EQ(far.step({{1.25, 0.5}}), StepStatus::kOk);
  for (int r = 0; r < 4; ++r) EXPECT_NEAR(near.latent()[r], far.latent()[r], 1e-13);  // rounding of 30 rad
}

}  // namespace
}  // namespace nlo
