// SPDX-License-Identifier: MIT
// status(channel) reports the health of each output and each input separately; the status of the step is the worst of
// them. Tested with each structure with two outputs and an input. Networks are zero, because statuses do not depend on
// them.
#include <nlo/driven_kkl_observer.h>
#include <nlo/gated_batch.h>
#include <nlo/gated_observer.h>
#include <nlo/general_observer.h>
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>
#include <nlo/luenberger_observer.h>
#include <nlo/sensor_failures.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <limits>
#include <random>

#include "tests/runtime/batch_twin.h"
#include "tests/runtime/structures.h"

namespace nlo {
namespace {

using testing::MixedMlp;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInf = std::numeric_limits<float>::infinity();
constexpr int kChannels = 3, kStaleAfter = 3;
using Samples = std::array<float, kChannels>;  // two outputs, then the input
constexpr Samples kGood = {1.0F, -2.0F, 0.5F};

template <int kIn, int kOut>
using Silent = LearnedMap<MixedMlp<float, kIn, kOut>>;
template <int kIn>
using SilentInverse = LearnedMap<MixedMlp<float, kIn, 2>>;

using Kkl = KklModel<float, 2, 2, 3, 1, SilentInverse<6>, 1>;
using Failing = KklModel<float, 2, 2, 3, 1, SilentInverse<7>, 1, Hold::kZeroOrder, 1>;  // the second may be missing
using Driven = DrivenKklModel<float, 2, 2, 3, 1, 1, SilentInverse<5>, Silent<2, 3>>;
template <int kOut>
using SilentLayer = LearnedMap<Mlp<Activation::kTanh, PackedDense<float, 6, kOut>>>;
using Gated = GatedModel<float, 2, 2, 3, SilentLayer<6>, SilentLayer<3>, SilentInverse<6>, 1>;
using General = GeneralModel<float, 2, 2, 2, Silent<5, 2>, Silent<2, 2>, 1>;
using Luenberger = LuenbergerModel<float, 2, 2, Silent<2, 2>, 1>;

/// All readings have the range +-10, at 50 Hz, stale after three samples; the staleness of an output is within 0 .. 1.
template <class Model>
constexpr Model silent() {
  Model model{};
  testing::set_sampling(model);
  model.stale_after = kStaleAfter;
  for (int j = 0; j < Model::kNr; ++j) {
    model.outputs.min[j] = -10.0F;
    model.outputs.max[j] = 10.0F;
  }
  if constexpr (Model::kNf > 0) {
    model.outputs.min[kChannels] = 0.0F;
    model.outputs.max[kChannels] = 1.0F;
    model.failures = {{1}, {0.0F}, 1.0F, 0.98F};
  }
  return model;
}

template <class Model>
inline constexpr Model kSilent = silent<Model>();

template <class Check>
void each_structure(const Check& check) {
  const auto with = [&](auto observer) { check(observer); };
  with(KklObserver<Kkl>(kSilent<Kkl>));
  with(KklObserver<Kkl, Arithmetic::kDeterministic>(kSilent<Kkl>));
  with(KklObserver<Failing>(kSilent<Failing>));
  with(KklObserver<Failing, Arithmetic::kDeterministic>(kSilent<Failing>));
  with(DrivenKklObserver<Driven>(kSilent<Driven>));
  with(GatedObserver<Gated>(kSilent<Gated>));
  with(GatedObserver<Gated, Arithmetic::kDeterministic>(kSilent<Gated>));
  with(GeneralObserver<General>(kSilent<General>));
  with(LuenbergerObserver<Luenberger>(kSilent<Luenberger>));
}

template <class Observer, class... Dt>
StepStatus step(Observer& observer, const Samples& s, Dt... dt_s) {
  return observer.step({{s[0], s[1]}}, {{s[2]}}, dt_s...);
}

template <class Observer>
constexpr bool may_be_missing(int channel) {
  return Observer::kNf > 0 && channel == 1;
}

/// The status of a channel after a sample, as docs/runtime.md defines it. bad: consecutive samples that were not used
/// unchanged; missed: samples that a step over a gap missed.
template <class Observer>
StepStatus expected(int channel, float sample, int& bad, int missed = 0) {
  const bool finite = sample - sample == 0.0F;
  if (!finite && may_be_missing<Observer>(channel)) {
    bad = 1;
    return StepStatus::kHeld;
  }
  const bool ranged = channel < Observer::kNr - Observer::kNf;  // inputs of an input field have no range
  const bool clamped = finite && ranged && (sample < -10.0F || sample > 10.0F), good = finite && !clamped;
  const int all = bad + missed + (good ? 0 : 1);
  bad = good ? 0 : all;
  if (good && missed == 0) return StepStatus::kOk;
  if (all >= kStaleAfter) return clamped ? StepStatus::kOutOfRange : StepStatus::kStale;
  return clamped && missed == 0 ? StepStatus::kClamped : StepStatus::kHeld;
}

TEST(ChannelStatus, OneBadChannelDoesNotAffectTheOthers) {
  each_structure([](auto& observer) {
    using Observer = std::remove_reference_t<decltype(observer)>;
    for (int bad = 0; bad < kChannels; ++bad) {
      for (const float sample : {kNan, kInf, -kInf, 11.0F, -11.0F}) {
        observer.reset();
        ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
        Samples samples = kGood;
        samples[static_cast<std::size_t>(bad)] = sample;
        int in_a_row = 0;
        for (int k = 0; k < 6; ++k) {
          const StepStatus of_bad = expected<Observer>(bad, sample, in_a_row);
          ASSERT_EQ(step(observer, samples), of_bad) << bad << " " << sample;
          for (int j = 0; j < kChannels; ++j) ASSERT_EQ(observer.status(j), j == bad ? of_bad : StepStatus::kOk) << j;
        }
        ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
        ASSERT_EQ(observer.status(bad), StepStatus::kOk) << "one good sample resets it";
      }
    }
  });
}

TEST(ChannelStatus, TheStepReportsTheWorstChannelForAnyInput) {
  each_structure([](auto& observer) {
    using Observer = std::remove_reference_t<decltype(observer)>;
    std::mt19937 random(5);
    int bad[kChannels] = {};
    int seen[static_cast<int>(StepStatus::kOutOfRange) + 1] = {}, differing = 0;
    ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
    for (int k = 0; k < 5000; ++k) {
      Samples samples;
      for (float& sample : samples) {
        const auto draw = random() % 8;
        sample = draw < 2 ? kNan : draw == 2 ? 40.0F : testing::uniform<float>(random, -9.0, 9.0);
      }
      const int periods = k % 5 == 0 ? 1 + static_cast<int>(random() % 4) : 1;
      const StepStatus all =
          k % 5 == 0 ? step(observer, samples, 0.02F * static_cast<float>(periods)) : step(observer, samples);
      StepStatus worst = StepStatus::kOk;
      for (int j = 0; j < kChannels; ++j) {
        const StepStatus want = expected<Observer>(j, samples[static_cast<std::size_t>(j)], bad[j], periods - 1);
        ASSERT_EQ(observer.status(j), want) << "channel " << j << ", step " << k;
        worst = std::max(worst, want);
      }
      ASSERT_EQ(all, worst) << k;
      ++seen[static_cast<int>(all)];
      differing += observer.status(0) != observer.status(1);
    }
    for (const int times : seen) EXPECT_GT(times, 50);
    EXPECT_GT(differing, 1000) << "control: channels often have different statuses";
  });
}

TEST(ChannelStatus, ChannelsThatFailInTurnAreHeldButNeverStale) {
  each_structure([](auto& observer) {
    ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
    for (std::size_t k = 0; k < 20; ++k) {
      Samples samples = kGood;
      samples[k % kChannels] = kNan;
      ASSERT_EQ(step(observer, samples), StepStatus::kHeld);
    }
  });
}

TEST(ChannelStatus, AChannelNumberOutOfRangeGivesRejected) {
  each_structure([](auto& observer) {
    ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
    for (const int none :
         {-1, kChannels, kChannels + 1, std::numeric_limits<int>::max(), std::numeric_limits<int>::min()})
      EXPECT_EQ(observer.status(none), StepStatus::kRejected) << none;
  });
}

TEST(ChannelStatus, ARejectedStepAppliesToAllChannelsAndChangesNoCount) {
  each_structure([](auto& observer) {
    ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
    Samples samples = kGood;
    samples[0] = kNan;
    for (int k = 0; k < kStaleAfter - 1; ++k) ASSERT_EQ(step(observer, samples), StepStatus::kHeld);
    ASSERT_EQ(step(observer, samples, -1.0F), StepStatus::kRejected);
    for (int j = 0; j < kChannels; ++j) EXPECT_EQ(observer.status(j), StepStatus::kRejected);
    ASSERT_EQ(step(observer, samples), StepStatus::kStale);
    EXPECT_EQ(observer.status(0), StepStatus::kStale);
    EXPECT_EQ(observer.status(1), StepStatus::kOk);
  });
}

TEST(ChannelStatus, AStartAndAWarmStartHoldMissingChannels) {
  each_structure([](auto& observer) {
    using Observer = std::remove_reference_t<decltype(observer)>;
    Samples samples = kGood;
    samples[0] = kNan;
    for (int k = 1; k <= 4; ++k) {
      ASSERT_EQ(step(observer, samples), k < kStaleAfter ? StepStatus::kHeld : StepStatus::kStale)
          << "the observer has not started";
      ASSERT_EQ(observer.status(0), k < kStaleAfter ? StepStatus::kHeld : StepStatus::kStale);
      ASSERT_EQ(observer.status(1), StepStatus::kOk);
    }
    if constexpr (Observer::Model::kHasSteadyState) {
      const auto warm = [&](float first, float second) {
        if constexpr (Observer::kReadsInputs)
          return observer.warm_start({{first, second}}, {{0.5F}});
        else
          return observer.warm_start({{first, second}});
      };
      ASSERT_EQ(warm(kNan, 1.0F), StepStatus::kStale);
      ASSERT_EQ(observer.status(0), StepStatus::kStale);
      ASSERT_EQ(warm(1.0F, 11.0F), StepStatus::kClamped);
      ASSERT_EQ(observer.status(0), StepStatus::kOk);
      ASSERT_EQ(observer.status(1), StepStatus::kClamped);
      ASSERT_EQ(observer.status(2), StepStatus::kOk);
      if constexpr (Observer::kNf > 0) {
        ASSERT_EQ(warm(1.0F, kNan), StepStatus::kHeld);
        ASSERT_EQ(observer.status(1), StepStatus::kHeld);
      }
    }
  });
}

TEST(ChannelStatus, IsRestoredWithTheStateAndResetByAGoodSample) {
  each_structure([](auto& observer) {
    using Observer = std::remove_reference_t<decltype(observer)>;
    ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
    Samples samples = kGood;
    samples[1] = kNan;
    for (int k = 0; k < 4; ++k) (void)step(observer, samples);
    Observer other(observer.model());
    ASSERT_TRUE(other.restore(observer.save()));
    for (int j = 0; j < kChannels; ++j) EXPECT_EQ(other.status(j), observer.status(j));
    EXPECT_NE(other.status(1), StepStatus::kOk) << "control";
    std::mt19937 random(6);
    for (int k = 0; k < 2000; ++k) {
      auto corrupted = observer.save();
      for (ChannelHealth& health : corrupted.health)
        health = static_cast<ChannelHealth>(random() >> (16 + random() % 16));
      ASSERT_TRUE(other.restore(corrupted)) << "any count can result from steps";
      for (int j = 0; j < kChannels; ++j) ASSERT_LE(other.status(j), StepStatus::kOutOfRange);
      (void)step(other, samples);
      for (int j = 0; j < kChannels; ++j) ASSERT_LE(other.status(j), StepStatus::kOutOfRange);
      ASSERT_EQ(step(other, kGood), StepStatus::kOk);
      for (int j = 0; j < kChannels; ++j) ASSERT_EQ(other.status(j), StepStatus::kOk);
    }
  });
}

TEST(ChannelStatus, ACorruptedLatentStateAppliesToAllChannels) {
  each_structure([](auto& observer) {
    using Observer = std::remove_reference_t<decltype(observer)>;
    struct Upset : Observer {
      explicit Upset(const Observer& from) : Observer(from) {}
      void corrupt() { this->state_.z[0] = kNan; }
    };
    ASSERT_EQ(step(observer, kGood), StepStatus::kOk);
    Upset upset(observer);
    upset.corrupt();
    for (int j = 0; j < kChannels; ++j) EXPECT_EQ(upset.status(j), StepStatus::kReset);
  });
}

TEST(ChannelStatus, InABatchEqualsThatOfASingleObserver) {
  constexpr int kPlants = 21;  // blocks that are stepped together, and a rest
  std::mt19937 random(8);
  const auto reading = [&random](int k, int /*plant*/, int /*channel*/) {
    const auto kind = k % 3 == 0 ? 9 : random() % 10;
    return kind < 3 ? kNan : kind == 3 ? 40.0F : testing::uniform<float>(random, -9.0, 9.0);
  };
  const auto check = [&](auto&& batch, auto observer) {
    EXPECT_LE(testing::off_observers<kPlants>(batch, observer, reading), 1e-5F);
  };
  check(KklBatch<Kkl, kPlants>(kSilent<Kkl>), KklObserver<Kkl>(kSilent<Kkl>));
  check(KklBatch<Failing, kPlants>(kSilent<Failing>), KklObserver<Failing>(kSilent<Failing>));
  check(GatedBatch<Gated, kPlants>(kSilent<Gated>), GatedObserver<Gated>(kSilent<Gated>));
}

}  // namespace
}  // namespace nlo
