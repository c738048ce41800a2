// SPDX-License-Identifier: MIT
// The deterministic policy screens without branches: the same outputs and statuses, bit for bit.
#include <nlo/measurement.h>

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

namespace nlo {
namespace {

/// Often an odd one: not a number, infinite, subnormal, on the edge or far out.
template <class Scalar>
Scalar any_measurement(std::mt19937& random) {
  using Limits = std::numeric_limits<Scalar>;
  constexpr Scalar kOdd[] = {Limits::quiet_NaN(),   Limits::infinity(), -Limits::infinity(), Limits::denorm_min(),
                             -Limits::denorm_min(), Limits::max(),      Limits::lowest(),    Scalar(0),
                             Scalar(-0.0),          Scalar(3),          Scalar(-3),          Scalar(3.0000005)};
  if (random() % 3 == 0) return kOdd[random() % std::size(kOdd)];
  return static_cast<Scalar>(std::uniform_real_distribution<double>(-4.0, 4.0)(random));
}

template <class Scalar>
void expect_the_same_screening() {
  // A length, an angle, a length.
  constexpr OutputRange<Scalar, 3> kRange{{-3, -3, 1}, {3, 3, 2}, {0, Scalar(6.2831853), 0}};
  std::mt19937 random(1);
  Scalar accepted[3] = {0, 0, 1}, evenly[3] = {0, 0, 1};
  std::uint16_t held = 0, held_evenly = 0;
  int statuses[8] = {};
  for (int k = 0; k < 100'000; ++k) {
    const Vector<Scalar, 3> y{{any_measurement<Scalar>(random), any_measurement<Scalar>(random),
                               k % 4 == 0 ? any_measurement<Scalar>(random) : Scalar(1.5)}};
    const StepStatus status = kRange.screen(y, accepted);
    ASSERT_EQ(kRange.screen_evenly(y, evenly), status) << k;
    ASSERT_EQ(std::memcmp(accepted, evenly, sizeof accepted), 0) << k;
    StepStatus noted = status;
    if (status == StepStatus::kHeld) {
      noted = note_held(held, 3);
    } else {
      held = 0;
    }
    ASSERT_EQ(note_evenly(status, held_evenly, 3), noted) << k;
    ASSERT_EQ(held_evenly, held) << k;
    ++statuses[static_cast<int>(noted)];
  }
  for (const StepStatus status : {StepStatus::kOk, StepStatus::kClamped, StepStatus::kHeld, StepStatus::kStale})
    EXPECT_GT(statuses[static_cast<int>(status)], 100) << "seldom seen: " << static_cast<int>(status);
}

TEST(EvenScreening, TakesWhatScreeningTakesInFloat) {
  expect_the_same_screening<float>();
}
TEST(EvenScreening, TakesWhatScreeningTakesInDouble) {
  expect_the_same_screening<double>();
}

TEST(EvenScreening, CountsNoFurtherThanItsCounter) {
  std::uint16_t held = 0xfffe;
  EXPECT_EQ(note_evenly(StepStatus::kHeld, held, 3), StepStatus::kStale);
  EXPECT_EQ(held, 0xffff);
  EXPECT_EQ(note_evenly(StepStatus::kHeld, held, 3), StepStatus::kStale);
  EXPECT_EQ(held, 0xffff);
}

TEST(Select, TakesOneOrTheOtherAsItIs) {
  const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
  const float nan = std::bit_cast<float>(0x7fc12345U);
  EXPECT_EQ(bits(select(true, nan, -0.0F)), 0x7fc12345U);
  EXPECT_EQ(bits(select(false, nan, -0.0F)), 0x80000000U);
  EXPECT_EQ(select(true, 1.5, 2.5), 1.5);
  EXPECT_EQ(select(false, std::uint16_t{7}, std::uint16_t{0xffff}), 0xffff);
  static_assert(select(true, StepStatus::kStale, StepStatus::kOk) == StepStatus::kStale);
}

}  // namespace
}  // namespace nlo
