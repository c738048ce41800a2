// SPDX-License-Identifier: MIT
// Both policies validate with the same code, one of them without branches: outputs and statuses equal those of a
// validation with plain branches, bit for bit. tests/properties/instruction_count.sh checks that the number of
// instructions does not depend on the measurement.
#include <nlo/measurement.h>

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <random>

namespace nlo {
namespace {

/// Validates one output with plain branches.
template <class Scalar>
StepStatus plainly_validated(Scalar y, Scalar min, Scalar max, Scalar wrap, Scalar& accepted) {
  if (!std::isfinite(y)) return StepStatus::kHeld;
  if (wrap > 0) {
    if (y < min || y > max) return StepStatus::kHeld;
    const Scalar turns = (y - accepted) / wrap;
    if (turns < Scalar(-0.5)) {
      accepted = y - wrap * std::trunc(turns - Scalar(0.5));
    } else if (turns > Scalar(0.5)) {
      accepted = y - wrap * std::trunc(turns + Scalar(0.5));
    } else {
      accepted = y;
    }
    return StepStatus::kOk;
  }
  accepted = y < min ? min : y > max ? max : y;
  return y < min || y > max ? StepStatus::kClamped : StepStatus::kOk;
}

/// Returns a measurement, often a special one: NaN, infinite, subnormal, at the edge or far out.
template <class Scalar>
Scalar any_measurement(std::mt19937& random) {
  using Limits = std::numeric_limits<Scalar>;
  constexpr Scalar kOdd[] = {Limits::quiet_NaN(),   Limits::infinity(), -Limits::infinity(), Limits::denorm_min(),
                             -Limits::denorm_min(), Limits::max(),      Limits::lowest(),    Scalar(0),
                             Scalar(-0.0),          Scalar(3),          Scalar(-3),          Scalar(3.0000005)};
  if (random() % 3 == 0) return kOdd[random() % std::size(kOdd)];
  return static_cast<Scalar>(std::uniform_real_distribution<double>(-4.0, 4.0)(random));
}

template <class Scalar, Arithmetic kArithmetic>
void expect_plain_validation() {
  // A length, an angle and a length.
  constexpr ReadingRange<Scalar, 3> kRange{{-3, -3, 1}, {3, 3, 2}, {0, Scalar(6.2831853), 0}};
  std::mt19937 random(1);
  Scalar accepted[3] = {0, 0, 1}, expected[3] = {0, 0, 1};
  ChannelHealth health[3] = {};
  int bad[3] = {};
  int statuses[8] = {};
  for (int k = 0; k < 100'000; ++k) {
    const Vector<Scalar, 3> y{{any_measurement<Scalar>(random), any_measurement<Scalar>(random),
                               k % 4 == 0 ? any_measurement<Scalar>(random) : Scalar(1.5)}};
    const bool held = kRange.template validate<kArithmetic>(y, accepted, health);
    bool any_held = false;
    for (int j = 0; j < 3; ++j) {
      StepStatus of_output = plainly_validated(y[j], kRange.min[j], kRange.max[j], kRange.wrap[j], expected[j]);
      any_held = any_held || of_output == StepStatus::kHeld;
      bad[j] = of_output == StepStatus::kOk ? 0 : bad[j] + 1;
      if (bad[j] >= 3) of_output = of_output == StepStatus::kHeld ? StepStatus::kStale : StepStatus::kOutOfRange;
      ASSERT_EQ(status_of<kArithmetic>(health[j], 3), of_output) << k;
      ++statuses[static_cast<int>(of_output)];
    }
    ASSERT_EQ(held, any_held) << k;
    ASSERT_EQ(std::memcmp(accepted, expected, sizeof accepted), 0) << k;
  }
  for (const StepStatus status :
       {StepStatus::kOk, StepStatus::kClamped, StepStatus::kHeld, StepStatus::kStale, StepStatus::kOutOfRange})
    EXPECT_GT(statuses[static_cast<int>(status)], 100) << "too rare in this test: " << static_cast<int>(status);
}

TEST(Validation, EqualsPlainBranchesForBothPolicies) {
  expect_plain_validation<float, Arithmetic::kFast>();
  expect_plain_validation<float, Arithmetic::kDeterministic>();
  expect_plain_validation<double, Arithmetic::kFast>();
  expect_plain_validation<double, Arithmetic::kDeterministic>();
}

TEST(Validation, StopsCountingAtTheLargestCount) {
  const auto expect_saturation = []<Arithmetic kArithmetic> {
    for (const std::uint32_t bits : {1U, 2U, 3U}) {
      for (const std::uint32_t count : {kMostCounted - 1, kMostCounted}) {
        const auto last = static_cast<ChannelHealth>(count << 2U | bits);
        EXPECT_EQ(next_health<kArithmetic>(last, false, false), kMostCounted << 2U | kHeldBit);
        EXPECT_EQ(next_health<kArithmetic>(last, true, true), kMostCounted << 2U | kClampedBit);
        EXPECT_EQ(next_health<kArithmetic>(last, true, false), 0);
        EXPECT_EQ(health_after_missed(last, 999), kMostCounted << 2U | kHeldBit);
      }
      // A model may set a limit above the largest count; the channel still becomes stale.
      EXPECT_GE(status_of<kArithmetic>(static_cast<ChannelHealth>(kMostCounted << 2U | bits), 0xffff),
                StepStatus::kStale);
    }
  };
  expect_saturation.operator()<Arithmetic::kFast>();
  expect_saturation.operator()<Arithmetic::kDeterministic>();
}

TEST(Select, ReturnsOneOfTwoValuesUnchanged) {
  const auto expect_choices = []<Arithmetic kArithmetic> {
    const auto bits = [](float value) { return std::bit_cast<std::uint32_t>(value); };
    const float nan = std::bit_cast<float>(0x7fc12345U);
    EXPECT_EQ(bits(select<kArithmetic>(true, nan, -0.0F)), 0x7fc12345U);
    EXPECT_EQ(bits(select<kArithmetic>(false, nan, -0.0F)), 0x80000000U);
    EXPECT_EQ(select<kArithmetic>(true, 1.5, 2.5), 1.5);
    EXPECT_EQ(select<kArithmetic>(false, std::uint16_t{7}, std::uint16_t{0xffff}), 0xffff);
    static_assert(select<kArithmetic>(true, StepStatus::kStale, StepStatus::kOk) == StepStatus::kStale);
  };
  expect_choices.operator()<Arithmetic::kFast>();
  expect_choices.operator()<Arithmetic::kDeterministic>();
}

}  // namespace
}  // namespace nlo
