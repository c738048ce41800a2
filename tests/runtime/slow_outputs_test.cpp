// SPDX-License-Identifier: MIT
// Outputs with a longer period of their own: between their samples nothing is missing, and a dead sensor is still
// detected.
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/runtime/batch_twin.h"

namespace nlo {
namespace {

constexpr float kNoSample = std::numeric_limits<float>::quiet_NaN();
constexpr int kSlowPeriod = 20, kSlowStaleAfter = 25;  // samples

using EachSample = KklModel<float, 2, 2, 2, 0, decltype(testing::identity_map<float, 2>())>;
/// A mode of unit gain for each output; the second output has a value in every 20th sample.
struct TwoRates : EachSample {
  static constexpr std::uint16_t kNotDue[kNr] = {0, kSlowPeriod - 1};
};
/// Values in every 20th and every 30th sample.
struct BothSlow : EachSample {
  static constexpr std::uint16_t kNotDue[kNr] = {kSlowPeriod - 1, 29};
};

template <class Model>
Model model_of() {
  Model m{};
  m.sample_period_s = 0.01F;
  m.stale_after = kSlowStaleAfter;
  m.latent.hold = Hold::kFirstOrder;
  for (int j = 0; j < 2; ++j) {
    m.latent.eigenvalues[j] = static_cast<float>(-2 - j);
    m.latent.output_injection[j][j] = static_cast<float>(2 + j);
    m.outputs.min[j] = -10.0F;
    m.outputs.max[j] = 10.0F;
    m.domain.latent_min[j] = -20.0F;
    m.domain.latent_max[j] = 20.0F;
  }
  m.inverse_map = testing::identity_map<float, 2>();
  testing::complete(m);
  return m;
}

template <class Model>
const Model kModelOf = model_of<Model>();

template <class Check>
void each_policy(const Check& check) {
  check([] { return KklObserver<TwoRates>(kModelOf<TwoRates>); });
  check([] { return KklObserver<TwoRates, Arithmetic::kDeterministic>(kModelOf<TwoRates>); });
}

TEST(SlowOutputs, HoldTheLastSampleWithoutBeingMissing) {
  each_policy([](const auto& make) {
    auto observer = make();
    KklObserver<EachSample> repeated(kModelOf<TwoRates>), without_period(kModelOf<TwoRates>);
    StepStatus worst_without_period = StepStatus::kOk;
    for (int k = 0; k < 200; ++k) {
      const float position = 0.1F * static_cast<float>(k / kSlowPeriod);
      const float given = k % kSlowPeriod == 0 ? position : kNoSample;
      ASSERT_EQ(observer.step({{1.0F, given}}), StepStatus::kOk) << k;
      ASSERT_EQ(observer.status(1), StepStatus::kOk);
      ASSERT_EQ(repeated.step({{1.0F, position}}), StepStatus::kOk);
      for (int r = 0; r < 2; ++r)
        ASSERT_EQ(observer.latent()[r], repeated.latent()[r]) << k << ": the last value is held";
      worst_without_period = worse<Arithmetic::kFast>(worst_without_period, without_period.step({{1.0F, given}}));
    }
    EXPECT_EQ(worst_without_period, StepStatus::kHeld) << "control: without its period the output is missing";
  });
}

TEST(SlowOutputs, AreLateAfterHalfAPeriodAndStaleByTheTimeOfTheDueSample) {
  each_policy([](const auto& make) {
    auto observer = make();
    (void)observer.step({{1.0F, 2.0F}});
    for (int k = 1; k < 200; ++k) {
      const StepStatus expected = k < kSlowPeriod * 3 / 2                 ? StepStatus::kOk
                                  : k - kSlowPeriod + 1 < kSlowStaleAfter ? StepStatus::kHeld
                                                                          : StepStatus::kStale;
      ASSERT_EQ(observer.step({{1.0F, kNoSample}}), expected) << k;
      ASSERT_EQ(observer.status(1), expected);
      ASSERT_EQ(observer.status(0), StepStatus::kOk);
    }
    EXPECT_EQ(observer.step({{1.0F, 2.0F}}), StepStatus::kOk) << "one sample resets it";
    for (int k = 1; k < kSlowPeriod * 3 / 2; ++k) ASSERT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kOk) << k;
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kHeld);
  });
}

TEST(SlowOutputs, DoNotHideAnotherMissingOutput) {
  each_policy([](const auto& make) {
    auto observer = make();
    (void)observer.step({{1.0F, 2.0F}});
    EXPECT_EQ(observer.step({{kNoSample, kNoSample}}), StepStatus::kHeld);
    EXPECT_EQ(observer.status(0), StepStatus::kHeld);
    EXPECT_EQ(observer.status(1), StepStatus::kOk);
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kOk);
  });
}

TEST(SlowOutputs, AreMissingUntilTheirFirstSampleAfterAReset) {
  each_policy([](const auto& make) {
    auto observer = make();
    for (int round = 0; round < 2; ++round) {
      for (int k = 0; k < 40; ++k) {
        ASSERT_GE(observer.step({{1.0F, kNoSample}}), StepStatus::kHeld) << k << ": no value is known";
        ASSERT_EQ(observer.save().started, 0);
      }
      EXPECT_EQ(observer.status(), StepStatus::kStale);
      EXPECT_EQ(observer.step({{1.0F, 3.0F}}), StepStatus::kOk);
      EXPECT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kOk);
      observer.reset();
    }
  });
}

TEST(SlowOutputs, StartTheObserverEvenIfTheyNeverArriveTogether) {
  KklObserver<BothSlow> observer(kModelOf<BothSlow>);
  const auto first = [](int k) { return k % kSlowPeriod == 3 ? 1.0F : kNoSample; };
  const auto second = [](int k) { return k % 30 == 11 ? 2.0F : kNoSample; };
  for (int k = 0; k < 11; ++k) ASSERT_GE(observer.step({{first(k), second(k)}}), StepStatus::kHeld) << k;
  EXPECT_EQ(observer.save().started, 0);
  for (int k = 11; k < 200; ++k) ASSERT_EQ(observer.step({{first(k), second(k)}}), StepStatus::kOk) << k;
  EXPECT_EQ(observer.save().y[0], 1.0F);
  EXPECT_EQ(observer.save().y[1], 2.0F);
}

TEST(SlowOutputs, AreReportedAsClampedWhileAClampedValueIsInUse) {
  each_policy([](const auto& make) {
    auto observer = make();
    (void)observer.step({{1.0F, 2.0F}});
    for (int k = 1; k < kSlowPeriod; ++k) (void)observer.step({{1.0F, kNoSample}});
    for (int k = 0; k < 60; ++k) {
      const StepStatus status = observer.step({{1.0F, k % kSlowPeriod == 0 ? 11.0F : kNoSample}});
      ASSERT_EQ(status, k + 1 < kSlowStaleAfter ? StepStatus::kClamped : StepStatus::kOutOfRange) << k;
      ASSERT_FALSE(observer.in_domain());
    }
    EXPECT_EQ(observer.step({{1.0F, 2.0F}}), StepStatus::kOk);
    EXPECT_TRUE(observer.in_domain());
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kOk);
  });
}

TEST(SlowOutputs, CountTheMissedSamplesOfAStepOverAGap) {
  each_policy([](const auto& make) {
    auto observer = make();
    (void)observer.step({{1.0F, 2.0F}});
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}, 0.1F), StepStatus::kHeld) << "nine samples of the first output";
    EXPECT_EQ(observer.status(1), StepStatus::kOk) << "the second was not due";
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}, 0.25F), StepStatus::kHeld);
    EXPECT_EQ(observer.status(0), StepStatus::kHeld);
    EXPECT_EQ(observer.status(1), StepStatus::kHeld) << "16 samples since it was due";
    EXPECT_EQ(observer.step({{1.0F, 2.0F}}), StepStatus::kOk);
  });
}

TEST(SlowOutputs, KeepTheirAgeOverSaveAndRestore) {
  each_policy([](const auto& make) {
    auto observer = make();
    (void)observer.step({{1.0F, 2.0F}});
    for (int k = 1; k < 25; ++k) (void)observer.step({{1.0F, kNoSample}});
    auto restored = make();
    ASSERT_TRUE(restored.restore(observer.save()));
    for (int k = 25; k < 60; ++k) {
      const StepStatus status = observer.step({{1.0F, kNoSample}});
      ASSERT_EQ(restored.step({{1.0F, kNoSample}}), status);
      if (k == 29 || k == 30) {
        ASSERT_EQ(status, k == 29 ? StepStatus::kOk : StepStatus::kHeld);
      }
    }
  });
}

TEST(SlowOutputs, AWarmStartUsesTheLastSampleAndNeedsOne) {
  KklObserver<TwoRates> observer(kModelOf<TwoRates>);
  EXPECT_GE(observer.warm_start({{1.0F, kNoSample}}), StepStatus::kHeld);
  EXPECT_EQ(observer.save().started, 0);
  EXPECT_EQ(observer.warm_start({{1.0F, 2.0F}}), StepStatus::kOk);
  EXPECT_EQ(observer.warm_start({{3.0F, kNoSample}}), StepStatus::kOk);
  EXPECT_EQ(observer.save().y[0], 3.0F);
  EXPECT_EQ(observer.save().y[1], 2.0F);
}

using MayFail = KklModel<float, 2, 2, 2, 0, decltype(testing::identity_map<float, 2>()), 0, Hold::kZeroOrder, 1>;
constexpr float kSlowRest = 3.0F, kSlowStaleness_s = 0.1F;
/// The slow output may also fail, and rests at 3.
struct SlowMayFail : MayFail {
  static constexpr std::uint16_t kNotDue[kNr] = {0, kSlowPeriod - 1, 0};
};

SlowMayFail slow_model_that_may_fail() {
  SlowMayFail m = model_of<SlowMayFail>();
  m.outputs.max[2] = 1.0F;
  m.failures = {{1}, {kSlowRest}, 1.0F / kSlowStaleness_s, std::exp(-0.01F / kSlowStaleness_s)};
  return m;
}
const SlowMayFail kSlowMayFail = slow_model_that_may_fail();

template <class Check>
void each_policy_that_may_fail(const Check& check) {
  check(KklObserver<SlowMayFail>(kSlowMayFail));
  check(KklObserver<SlowMayFail, Arithmetic::kDeterministic>(kSlowMayFail));
}

TEST(SlowOutputsThatMayFail, HoldTheirValueUntilTheyAreLateAndThenFadeByTheClosedForm) {
  each_policy_that_may_fail([](auto observer) {
    constexpr int kFirstLate = kSlowPeriod * 3 / 2;
    for (int k = 0; k < 2 * kSlowPeriod; ++k) {
      const float given = k % kSlowPeriod == 0 ? -2.0F : kNoSample;
      ASSERT_EQ(observer.step({{1.0F, given}}), StepStatus::kOk) << k;
      ASSERT_EQ(observer.save().y[1], -2.0F) << k;
      ASSERT_EQ(observer.staleness(1), 0.0F) << k;
      ASSERT_EQ(observer.has_arrived(1), k % kSlowPeriod == 0);
    }
    for (int since = kSlowPeriod; since < 2000; ++since) {  // samples since the last value
      const StepStatus status = observer.step({{1.0F, kNoSample}});
      ASSERT_EQ(status, since < kFirstLate ? StepStatus::kOk : StepStatus::kHeld) << since << ": never stale";
      ASSERT_EQ(observer.status(1), status);
      const float left = std::exp(-0.01F / kSlowStaleness_s * static_cast<float>(std::max(0, since - kFirstLate + 1)));
      ASSERT_NEAR(observer.save().y[1], kSlowRest + left * (-2.0F - kSlowRest), 1e-5F) << since;
      ASSERT_NEAR(observer.staleness(1), 1.0F - left, 1e-5F) << since;
    }
    EXPECT_EQ(observer.step({{1.0F, 4.0F}}), StepStatus::kOk) << "one sample resets it";
    EXPECT_EQ(observer.save().y[1], 4.0F);
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kOk);
    EXPECT_EQ(observer.save().y[1], 4.0F);
  });
}

TEST(SlowOutputsThatMayFail, DoNotPreventTheStart) {
  each_policy_that_may_fail([](auto observer) {
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kHeld);
    EXPECT_EQ(observer.save().started, 1);
    EXPECT_EQ(observer.save().y[1], kSlowRest);
    EXPECT_EQ(observer.step({{1.0F, 2.0F}}), StepStatus::kOk);
    EXPECT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kOk);
    EXPECT_EQ(observer.save().y[1], 2.0F);
  });
}

TEST(SlowOutputsThatMayFail, AlsoFadeAfterAClampedValue) {
  each_policy_that_may_fail([](auto observer) {
    for (int k = 0; k < 200; ++k) {  // out of range for ten periods
      ASSERT_EQ(observer.step({{1.0F, k % kSlowPeriod == 0 ? 11.0F : kNoSample}}), StepStatus::kClamped) << k;
      ASSERT_EQ(observer.save().y[1], 10.0F);
    }
    // A clamped sample counts as a bad one, so the output is late one sample earlier.
    for (int since = kSlowPeriod; since < kSlowPeriod * 3 / 2 - 1; ++since)
      ASSERT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kClamped) << since;
    for (int k = 0; k < 100; ++k) ASSERT_EQ(observer.step({{1.0F, kNoSample}}), StepStatus::kHeld) << k;
    EXPECT_NEAR(observer.save().y[1], kSlowRest, 0.01F);
  });
}

TEST(SlowOutputsThatMayFail, CountTheMissedSamplesOfAStepOverAGap) {
  each_policy_that_may_fail([](auto observer) {
    (void)observer.step({{1.0F, -2.0F}});
    (void)observer.step({{1.0F, kNoSample}}, 0.29F);
    EXPECT_EQ(observer.status(1), StepStatus::kOk) << "29 samples";
    EXPECT_EQ(observer.save().y[1], -2.0F);
    (void)observer.step({{1.0F, kNoSample}}, 0.02F);
    EXPECT_EQ(observer.status(1), StepStatus::kHeld) << "31 samples";
    EXPECT_NEAR(observer.staleness(1), 1.0F - std::exp(-0.02F / kSlowStaleness_s), 1e-5F);
  });
}

TEST(SlowOutputs, InABatchEqualThoseOfSingleObservers) {
  constexpr int kPlants = 16;
  KklBatch<TwoRates, kPlants> batch(kModelOf<TwoRates>);
  KklObserver<TwoRates> observer(kModelOf<TwoRates>);
  for (int k = 0; k < 150; ++k) {
    const float slow = k % kSlowPeriod == 0 && k < 80 ? 2.0F : kNoSample;
    float y[2][kPlants];
    for (int n = 0; n < kPlants; ++n) y[0][n] = 1.0F, y[1][n] = slow;
    const StepStatus expected = observer.step({{1.0F, slow}});
    ASSERT_EQ(batch.step(y), expected) << k;
    for (int n = 0; n < kPlants; ++n) ASSERT_EQ(batch.status(n, 1), observer.status(1));
  }
  EXPECT_EQ(batch.status(3), StepStatus::kStale) << "the sensor is dead";
}

}  // namespace
}  // namespace nlo
