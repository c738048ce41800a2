// SPDX-License-Identifier: MIT
// Any number as a measurement in any channel: its effect, and z stays finite.
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/runtime/testing.h"

namespace nlo {
namespace {

using testing::angle_model;
using testing::pair_model;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr auto kModel = pair_model<float>(Hold::kFirstOrder);  // stale after 3
using Observer = KklObserver<testing::PairModel<float>>;
using AngleObserver = KklObserver<testing::AngleModel<float>>;

template <class Observer>
bool latent_is_finite(const Observer& observer) {
  for (const auto z : observer.latent()) {
    if (!is_finite(z)) return false;
  }
  return true;
}

TEST(IsFinite, AgreesWithTheExponentOfEveryFloat) {
  for (std::uint32_t exponent = 0; exponent < 512; ++exponent) {
    for (const std::uint32_t mantissa : {0U, 1U, 0x400000U, 0x7fffffU}) {
      const auto value = std::bit_cast<float>(exponent << 23 | mantissa);
      EXPECT_EQ(is_finite(value), exponent % 256 != 255) << exponent << ' ' << mantissa;
    }
  }
  EXPECT_FALSE(is_finite(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(is_finite(-std::numeric_limits<double>::infinity()));
  EXPECT_TRUE(is_finite(std::numeric_limits<double>::max()));
}

TEST(Measurement, IsReplacedByTheLastGoodOneIfNotFinite) {
  for (const float bad :
       {kNan, -kNan, kInf, -kInf, std::bit_cast<float>(0x7f800001U), std::bit_cast<float>(0xffffffffU)}) {
    Observer observer(kModel), repeated(kModel);
    for (const float y : {1.0F, 2.0F}) {
      ASSERT_EQ(observer.step(y), StepStatus::kOk);
      ASSERT_EQ(repeated.step(y), StepStatus::kOk);
    }
    EXPECT_EQ(observer.step(bad), StepStatus::kHeld);
    EXPECT_EQ(repeated.step(2.0F), StepStatus::kOk);
    EXPECT_TRUE(testing::same_latent(observer.save(), repeated.save()));
    EXPECT_EQ(observer.status(), StepStatus::kHeld);
  }
}

TEST(Measurement, CountsAsNotFiniteIfItIsMissed) {
  Observer missed(kModel), not_finite(kModel);
  for (Observer* observer : {&missed, &not_finite}) ASSERT_EQ(observer->step(1.0F), StepStatus::kOk);
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(missed.step_missed(), not_finite.step(kNan));
    EXPECT_TRUE(testing::same_bits(missed.save(), not_finite.save()));
  }
}

TEST(Measurement, IsStaleAfterTooManyHeldInARowUntilAGoodOne) {
  Observer observer(kModel);
  ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
  for (int round = 0; round < 3; ++round) {
    EXPECT_EQ(observer.step(kNan), StepStatus::kHeld);
    EXPECT_EQ(observer.step(kNan), StepStatus::kHeld);
    for (int k = 0; k < 4; ++k) EXPECT_EQ(observer.step(kNan), StepStatus::kStale);
    EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
    EXPECT_EQ(observer.save().health[0], 0);
  }
}

TEST(Measurement, StaysStaleForAnyTimeItIsHeld) {
  Observer observer(kModel);
  ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
  for (int k = 0; k < 2; ++k) ASSERT_EQ(observer.step(kNan), StepStatus::kHeld);
  for (int k = 0; k < 70000; ++k)
    ASSERT_EQ(observer.step(kNan), StepStatus::kStale) << k;  // more than 16 bits can count
}

TEST(Measurement, DoesNotStartTheObserverIfItIsBad) {
  Observer observer(kModel);
  const auto fresh = observer.save();
  EXPECT_EQ(observer.step(kNan), StepStatus::kHeld);
  EXPECT_EQ(observer.step(kInf), StepStatus::kHeld);
  EXPECT_EQ(observer.step_missed(), StepStatus::kStale);
  EXPECT_TRUE(testing::same_latent(observer.save(), fresh));
  EXPECT_EQ(observer.save().started, 0);
  EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
  EXPECT_EQ(observer.save().started, 1);
}

TEST(Measurement, IsClampedToItsRange) {
  for (const float sign : {1.0F, -1.0F}) {
    for (const float size : {10.0000010F, 11.0F, 1e30F, std::numeric_limits<float>::max()}) {
      Observer observer(kModel), at_limit(kModel);
      ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
      ASSERT_EQ(at_limit.step(1.0F), StepStatus::kOk);
      EXPECT_EQ(observer.step(sign * size), StepStatus::kClamped);
      EXPECT_EQ(at_limit.step(sign * 10.0F), StepStatus::kOk);
      EXPECT_TRUE(testing::same_latent(observer.save(), at_limit.save()));
    }
  }
}

TEST(Measurement, HeldAndClampedOnesAreCountedTogether) {
  Observer observer(kModel);
  for (const float y : {1.0F, kNan, 99.0F}) (void)observer.step(y);
  EXPECT_EQ(observer.status(), StepStatus::kClamped);
  EXPECT_EQ(observer.step(kNan), StepStatus::kStale);
  EXPECT_EQ(observer.step(99.0F), StepStatus::kOutOfRange);
  EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
  EXPECT_EQ(observer.step(kNan), StepStatus::kHeld);
}

TEST(Measurement, IsOutOfRangeAfterATimeConstantOfClampingUntilAGoodOne) {
  Observer observer(kModel);
  ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
  for (int round = 0; round < 3; ++round) {
    for (int k = 1; k < 70000; ++k)
      ASSERT_EQ(observer.step(99.0F), k < 3 ? StepStatus::kClamped : StepStatus::kOutOfRange) << k;
    EXPECT_EQ(observer.status(0), StepStatus::kOutOfRange);
    EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
  }
}

TEST(Measurement, IsOutsideOfTheDomainIfItIsClamped) {
  auto model = kModel;
  for (int r = 0; r < 3; ++r) {
    model.domain.latent_min[r] = -1e3F;
    model.domain.latent_max[r] = 1e3F;
  }
  Observer observer(model);
  ASSERT_EQ(observer.step(9.9F), StepStatus::kOk);
  EXPECT_TRUE(observer.in_domain());
  ASSERT_EQ(observer.step(10.1F), StepStatus::kClamped);
  EXPECT_FALSE(observer.in_domain());
  ASSERT_EQ(observer.step(kNan), StepStatus::kHeld);
  EXPECT_TRUE(observer.in_domain()) << "a held reading is an earlier one that was in range";
  ASSERT_EQ(observer.step(9.9F), StepStatus::kOk);
  EXPECT_TRUE(observer.in_domain());
}

TEST(Measurement, HasTheStatusOfTheMissedSamplesAfterAGapAndResetsTheCount) {
  constexpr float kPeriod = 0.02F;  // stale after 3
  auto model = kModel;
  for (int r = 0; r < 3; ++r) {
    model.domain.latent_min[r] = -1e3F;
    model.domain.latent_max[r] = 1e3F;
  }
  for (const bool clamped : {false, true}) {
    Observer observer(model);
    const float y = clamped ? 99.0F : 2.0F;
    const auto after = [&](float periods) {
      EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
      const StepStatus status = observer.step(y, periods * kPeriod);
      EXPECT_EQ(observer.status(0), status);
      EXPECT_EQ(observer.status(), status);
      EXPECT_EQ(observer.in_domain(), !clamped);
      EXPECT_EQ(observer.save().y[0], clamped ? 10.0F : 2.0F) << "the reading is used";
      return status;
    };
    EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
    EXPECT_EQ(after(0.3F), clamped ? StepStatus::kClamped : StepStatus::kOk);
    EXPECT_EQ(after(1.45F), clamped ? StepStatus::kClamped : StepStatus::kOk) << "jitter";
    EXPECT_EQ(after(1.6F), StepStatus::kHeld) << "1 missed sample";
    EXPECT_EQ(after(3.0F), clamped ? StepStatus::kOutOfRange : StepStatus::kHeld) << "2 missed samples";
    EXPECT_EQ(after(4.0F), clamped ? StepStatus::kOutOfRange : StepStatus::kStale) << "3 missed samples";
    EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
    EXPECT_EQ(observer.step(2.0F, 3.0F * kPeriod), StepStatus::kHeld);
    EXPECT_EQ(observer.step(kNan), StepStatus::kHeld) << "the count starts again";
    EXPECT_EQ(observer.step(kNan), StepStatus::kHeld);
    EXPECT_EQ(observer.step(kNan), StepStatus::kStale);
    EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
  }
}

TEST(Measurement, MissedSamplesBeforeAndInAGapAreCountedTogether) {
  Observer observer(kModel), other(kModel);
  ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
  ASSERT_EQ(observer.step(kNan), StepStatus::kHeld);
  EXPECT_EQ(observer.step(1.0F, 3 * 0.02F), StepStatus::kStale) << "1 held and 2 missed samples";
  EXPECT_EQ(observer.step(kNan), StepStatus::kHeld);
  EXPECT_EQ(observer.step(kNan, 2 * 0.02F), StepStatus::kStale) << "1 held, 1 missed and 1 held sample";
  EXPECT_EQ(observer.step(1.0F, -1.0F), StepStatus::kRejected);
  EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
  EXPECT_EQ(other.step(1.0F, 0.5F), StepStatus::kOk) << "no sample can be missed before the first measurement";
}

TEST(Measurement, IsUsedUnchangedIfItIsSubnormal) {
  Observer observer(kModel);
  for (const float y : {1e-45F, -1e-45F, 1e-39F, std::numeric_limits<float>::denorm_min(), -0.0F}) {
    EXPECT_EQ(observer.step(y), StepStatus::kOk);
    EXPECT_EQ(std::bit_cast<std::uint32_t>(observer.save().y[0]), std::bit_cast<std::uint32_t>(y));
    EXPECT_TRUE(latent_is_finite(observer));
  }
}

TEST(Measurement, DoesNotAffectTheOtherChannelIfItIsBad) {
  const auto model = angle_model<float>();
  AngleObserver observer(model);
  ASSERT_EQ(observer.step({{0.5F, 0.25F}}), StepStatus::kOk);
  EXPECT_EQ(observer.step({{kNan, 0.5F}}), StepStatus::kHeld);
  EXPECT_EQ(observer.save().y[0], 0.5F);
  EXPECT_EQ(observer.save().y[1], 0.5F);
  EXPECT_EQ(observer.step({{0.75F, kInf}}), StepStatus::kHeld);
  EXPECT_EQ(observer.save().y[0], 0.75F);
  EXPECT_EQ(observer.save().y[1], 0.5F);
  EXPECT_EQ(observer.step({{kNan, 2.0F}}), StepStatus::kHeld);  // held is worse than clamped
  EXPECT_EQ(observer.save().y[1], 1.0F);
  EXPECT_EQ(observer.step({{0.75F, 0.5F}}), StepStatus::kOk);
  EXPECT_EQ(observer.step({{0.75F, 2.0F}}), StepStatus::kClamped);
}

TEST(Measurement, AnAngleOutOfRangeIsHeldInsteadOfClamped) {
  const auto model = angle_model<float>();
  AngleObserver observer(model);
  ASSERT_EQ(observer.step({{0.5F, 0.0F}}), StepStatus::kOk);
  for (const float bad : {3.2F, -3.2F, 1e30F}) {
    (void)observer.step({{0.5F, 0.0F}});
    EXPECT_EQ(observer.step({{bad, 0.0F}}), StepStatus::kHeld);
    EXPECT_FLOAT_EQ(observer.save().y[0], 0.5F);
  }
}

/// A million steps with random bits, and sometimes a good measurement, so that z moves.
template <class Observer>
void fuzz(const typename Observer::Model& model, std::uint32_t seed) {
  using Scalar = typename Observer::Scalar;
  constexpr int kSteps = 1'000'000, kStatuses = static_cast<int>(StepStatus::kRejected) + 1;
  Observer observer(model);
  std::mt19937 random(seed);
  int seen[kStatuses] = {};
  std::uint32_t missing = 0;  // number of measurements still to miss
  for (int k = 0; k < kSteps; ++k) {
    typename Observer::Output y{};
    if (random() % 16 == 0) missing = random() % 8;
    for (Scalar& value : y) {
      const auto kind = random() % 4;
      value = kind == 0 ? testing::any_bits<Scalar>(random) : testing::uniform<Scalar>(random, -3.2, 3.2);
      if (kind == 1) value *= Scalar(10);
      if (missing > 0) value = std::numeric_limits<Scalar>::quiet_NaN();
    }
    if (missing > 0) --missing;
    const auto way = random() % 64;
    StepStatus status;
    if (way == 0) {
      status = observer.warm_start(y);
    } else if (way < 32) {
      status = observer.step(y);
    } else if (way < 48) {
      status = observer.step(y, testing::any_bits<Scalar>(random));
    } else {
      status = observer.step(y, testing::uniform<Scalar>(random, 0, 1001) * model.sample_period_s);
    }
    ++seen[static_cast<int>(status)];
    ASSERT_TRUE(latent_is_finite(observer)) << "step " << k << ", seed " << seed;
    if (k % 1000 == 0) {
      ASSERT_TRUE(observer.restore(observer.save())) << "step " << k << ", seed " << seed;
    }
  }
  for (int status = 0; status < kStatuses; ++status) EXPECT_GT(seen[status], 1000) << status;
}

TEST(Fuzz, KeepsTheLatentStateFinite) {
  fuzz<Observer>(kModel, 1);
  fuzz<Observer>(pair_model<float>(Hold::kZeroOrder, true), 2);
  fuzz<KklObserver<testing::PairModel<double>>>(pair_model<double>(Hold::kFirstOrder), 3);
}

TEST(Fuzz, KeepsTheLatentStateOfAnRk4ModelFinite) {
  fuzz<Observer>(pair_model<float>(Hold::kRk4), 4);
}

TEST(Fuzz, KeepsTheLatentStateOfAnAngleFinite) {
  fuzz<AngleObserver>(angle_model<float>(), 5);
  fuzz<AngleObserver>(angle_model<float>(0.0, 2 * testing::kPi), 6);
  fuzz<AngleObserver>(angle_model<float>(-400.0, 400.0, false), 7);
  fuzz<KklObserver<testing::AngleModel<double>>>(angle_model<double>(), 8);
}

}  // namespace
}  // namespace nlo
