// SPDX-License-Identifier: MIT
// For any input, each structure keeps z finite, reports a status, and can be saved and restored.
#include <nlo/driven_kkl_observer.h>
#include <nlo/general_observer.h>
#include <nlo/luenberger_observer.h>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "tests/runtime/structures.h"

namespace nlo {
namespace {

using testing::driven_model;
using testing::each_structure;
using testing::general_model;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Returns a vector with all entries equal.
template <class Vector, class Scalar>
Vector filled(Scalar value) {
  Vector all{};
  for (auto& entry : all) entry = value;
  return all;
}

/// A step of any observer, with inputs if it has any.
template <class Observer, class Scalar, class... Dt>
StepStatus step(Observer& observer, Scalar y, Scalar u, Dt... dt_s) {
  const auto output = filled<typename Observer::Output>(y);
  if constexpr (Observer::kDriven) {
    return observer.step(output, filled<typename Observer::Input>(u), dt_s...);
  } else {
    return observer.step(output, dt_s...);
  }
}

template <class Observer>
void expect_sane(const Observer& observer) {
  for (const auto z : observer.latent()) ASSERT_TRUE(is_finite(z));
  Observer other = observer;
  ASSERT_TRUE(other.restore(observer.save())) << "restore() refuses a state that stepping can reach";
}

template <class Scalar>
void fuzz(unsigned seed) {
  each_structure<Scalar>([seed](auto& observer) {
    std::mt19937 random(seed);
    for (int k = 0; k < 20000; ++k) {
      const bool wild = random() % 4 == 0;
      const auto draw = [&] {
        return wild ? testing::any_bits<Scalar>(random) : testing::uniform<Scalar>(random, -12.0, 12.0);
      };
      const Scalar y = draw(), u = draw();
      if (random() % 3 == 0) {
        (void)step(observer, y, u, wild ? draw() : testing::uniform<Scalar>(random, -0.01, 1.4));
      } else {
        (void)step(observer, y, u);
      }
      expect_sane(observer);
      if (::testing::Test::HasFatalFailure()) return;
    }
  });
}

TEST(EveryStructure, StaysFiniteForAnyInput) {
  constexpr unsigned kSeed = 20;
  fuzz<float>(kSeed);
  fuzz<double>(kSeed);
}

TEST(EveryStructure, HoldsABadMeasurementAndBecomesStale) {
  each_structure<float>([](auto& observer) {
    ASSERT_EQ(step(observer, kNaN, 0.0F), StepStatus::kHeld);  // no value to hold yet
    ASSERT_EQ(observer.latent()[0], observer.model().initial_latent()[0]);
    ASSERT_EQ(step(observer, 1.0F, 0.0F), StepStatus::kOk);
    ASSERT_EQ(step(observer, kNaN, 0.0F), StepStatus::kHeld);
    ASSERT_EQ(step(observer, kInfinity, 0.0F), StepStatus::kHeld);
    ASSERT_EQ(step(observer, -kInfinity, 0.0F), StepStatus::kStale);
    ASSERT_EQ(step(observer, 1e30F, 0.0F), StepStatus::kOutOfRange);
    ASSERT_EQ(step(observer, 1.0F, 0.0F), StepStatus::kOk);
  });
}

TEST(EveryStructure, AMissedSampleEqualsTheLastOneRepeated) {
  each_structure<float>([](auto& observer) {
    auto other = observer;
    for (const float y : {1.0F, 1.5F, 0.5F}) {
      ASSERT_EQ(step(observer, y, 0.3F), StepStatus::kOk);
      ASSERT_EQ(step(other, y, 0.3F), StepStatus::kOk);
    }
    ASSERT_EQ(step(observer, kNaN, 0.3F), StepStatus::kHeld);
    ASSERT_EQ(step(other, 0.5F, 0.3F), StepStatus::kOk);
    using Model = typename std::remove_reference_t<decltype(observer)>::Model;
    constexpr bool kRepeats = !requires {
      Model::kReadsArrivals;
    };  // these predict over the missing output
    ASSERT_EQ(testing::same_latent(observer.save(), other.save()), kRepeats);
  });
}

TEST(EveryStructure, RefusesStepsThatItCannotSpan) {
  each_structure<float>([](auto& observer) {
    using Model = typename std::remove_reference_t<decltype(observer)>::Model;
    ASSERT_EQ(step(observer, 1.0F, 0.0F), StepStatus::kOk);
    (void)step(observer, kNaN, 0.0F);
    auto before = observer.save();
    before.status = StepStatus::kRejected;
    const float longest = 0.02F * static_cast<float>(Model::kLongestGap);
    for (const float dt : {0.0F, -0.0F, -0.02F, kNaN, kInfinity, -kInfinity, 1.0005F * longest, 3e38F}) {
      ASSERT_EQ(step(observer, 2.0F, 0.0F, dt), StepStatus::kRejected) << dt;
      ASSERT_TRUE(testing::same_bits(observer.save(), before)) << dt;
    }
    for (const float dt : {1e-45F, 1e-30F, 0.02F, longest})
      ASSERT_EQ(step(observer, 2.0F, 0.0F, dt), dt < longest ? StepStatus::kOk : StepStatus::kStale) << dt;
  });
}

TEST(EveryStructure, RestoresItsStateBitForBitAndContinues) {
  each_structure<float>([](auto& observer) {
    auto other = observer;
    std::mt19937 random(5);
    const auto draw = [&random] { return testing::uniform<float>(random, -12, 12); };
    for (int k = 0; k < 300; ++k) {
      (void)step(observer, k % 7 == 0 ? kNaN : draw(), draw());
      const auto saved = observer.save();
      ASSERT_TRUE(other.restore(saved));
      ASSERT_TRUE(testing::same_bits(other.save(), saved));
    }
    for (int k = 0; k < 100; ++k) {
      const float y = draw(), u = draw();
      ASSERT_EQ(step(observer, y, u), step(other, y, u));
      ASSERT_TRUE(testing::same_bits(observer.save(), other.save()));
    }
    auto damaged = observer.save();
    damaged.z[0] = kNaN;
    ASSERT_FALSE(other.restore(damaged));
  });
}

/// An observer whose memory can be changed by a bit flip.
template <class Observer>
struct Upset : Observer {
  explicit Upset(const Observer& observer) : Observer(observer) {}

  template <class Value>
  void flip(Value& value, int bit) {
    unsigned char bytes[sizeof(Value)];
    std::memcpy(bytes, &value, sizeof(Value));
    bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ (1U << (bit % 8)));
    std::memcpy(&value, bytes, sizeof(Value));
  }
  auto& memory() { return this->state_; }
};

/// Flips each bit of z and y in turn and continues. Returns how many flips gave kReset.
template <class Observer>
int upset_everywhere(const Observer& running) {
  using Scalar = typename Observer::Scalar;
  constexpr int kBits = 8 * sizeof(Scalar);
  int seen = 0;
  const auto fly = [&](Upset<Observer> observer, bool of_z) {
    const bool corrupted = !is_reachable(observer.memory(), running.model().outputs);
    EXPECT_EQ(observer.status() == StepStatus::kReset, corrupted) << "reported at once";
    const bool z_corrupted = !is_reachable(observer.memory().z);
    if (!corrupted) {
      for (const Scalar x : observer.estimate())
        EXPECT_TRUE(is_finite(x)) << "without kReset the estimate must be finite";
    }
    const StepStatus first = step(observer, Scalar(1.0), Scalar(0.3));
    if (z_corrupted && of_z && first == StepStatus::kOk) {  // the step did not detect it
      Observer other(running);
      (void)step(other, Scalar(1.0), Scalar(0.3));
      EXPECT_TRUE(testing::same_latent(observer.save(), other.save()));
    }
    for (int k = 0; k < 3; ++k) {
      for (const Scalar z : observer.latent()) EXPECT_TRUE(is_finite(z));
      const StepStatus status = step(observer, Scalar(1.0), Scalar(0.3));
      if (k > 0) {
        EXPECT_NE(status, StepStatus::kReset) << "it continues normally";
      }
    }
    if (first != StepStatus::kReset) return;
    ++seen;
    Observer fresh(running.model());
    (void)step(fresh, Scalar(1.0), Scalar(0.3));
    for (int k = 0; k < 2; ++k) (void)step(fresh, Scalar(1.0), Scalar(0.3));
    EXPECT_TRUE(testing::same_latent(observer.save(), fresh.save())) << "as a new observer";
  };
  for (int r = 0; r < Observer::kNz; ++r)
    for (int bit = 0; bit < kBits; ++bit) {
      Upset<Observer> observer(running);
      observer.flip(observer.memory().z[r], bit);
      fly(observer, true);
    }
  for (int j = 0; j < Observer::kNr; ++j)
    for (int bit = 0; bit < kBits; ++bit) {
      Upset<Observer> observer(running);
      observer.flip(observer.memory().y[j], bit);
      fly(observer, false);
    }
  return seen;
}

TEST(EveryStructure, DetectsABitFlipThatMakesZUnreachableAndRestarts) {
  int seen = 0;
  const auto check = [&](auto& observer) {
    using Scalar = typename std::remove_reference_t<decltype(observer)>::Scalar;
    for (int k = 0; k < 5; ++k) (void)step(observer, Scalar(0.8) + Scalar(0.1) * static_cast<Scalar>(k), Scalar(0.3));
    seen += upset_everywhere(observer);
  };
  each_structure<float>(check);
  EXPECT_GT(seen, 10) << "control: the highest bit of an exponent gives an unreachable state";
  seen = 0;
  each_structure<double>(check);
  EXPECT_GT(seen, 10);
}

TEST(EveryStructure, StartsFromAGivenLatentState) {
  each_structure<float>([](auto& observer) {
    using Observer = std::remove_reference_t<decltype(observer)>;
    const auto reset_to = [&](const typename Observer::Latent& z0) {
      const auto y0 = filled<typename Observer::Output>(2.0F);
      if constexpr (Observer::kReadsInputs) return observer.reset(z0, y0, filled<typename Observer::Input>(0.3F));
      if constexpr (!Observer::kReadsInputs) return observer.reset(z0, y0);
    };
    auto z0 = observer.latent();
    z0[0] = 1.25F;
    ASSERT_TRUE(reset_to(z0));
    ASSERT_EQ(observer.latent()[0], 1.25F);
    z0[0] = kInfinity;
    ASSERT_FALSE(reset_to(z0));
    ASSERT_EQ(observer.latent()[0], 1.25F);
  });
}

TEST(GeneralObserver, KeepsItsLastLatentStateAndReportsItIfItDiverges) {
  auto model = general_model<float>();
  model.dynamics.linear_path.weights[0][0] = 60.0F;  // grows by exp(1.2) per sample
  GeneralObserver observer(model);
  int diverged = 0;
  for (int k = 0; k < 200; ++k) {
    const auto before = observer.latent();
    if (observer.step(1.0F) != StepStatus::kDiverged) continue;
    ++diverged;
    for (int r = 0; r < 2; ++r) ASSERT_EQ(observer.latent()[r], before[r]);
    ASSERT_FALSE(observer.in_domain());
  }
  EXPECT_GT(diverged, 50);
  observer.reset();
  EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
  EXPECT_EQ(observer.step(1.0F), StepStatus::kOk);
}

/// x_1' = 1 / 0 for x_0 below 1.
struct DividingEquations : testing::OscillatorEquations<float> {
  static constexpr void derivative(const float (&x)[5], const float*, float (&dx)[5]) {
    for (float& slope : dx) slope = 0.0F;
    dx[1] = 1.0F / (x[0] > 1.0F ? 2.0F : 0.0F);
  }
};

TEST(PriorObserver, ADivisionByZeroIsReportedInsteadOfClamped) {
  const auto model = testing::prior_model<float, DividingEquations>();
  PriorObserver observer(model);
  for (int k = 0; k < 5; ++k) {
    EXPECT_EQ(observer.step(0.0F), StepStatus::kOk) << "the first measurement does not divide";
    EXPECT_EQ(observer.step(0.0F), StepStatus::kReset) << "infinite; a clamp would turn it into the end of the range";
    for (int r = 0; r < 9; ++r) ASSERT_TRUE(std::isfinite(observer.latent()[r]));
  }
}

// Fails if a held output counts as a measurement: the variance of its state would shrink.
TEST(PriorObserver, PredictsOverAMissingOutput) {
  const auto model = testing::prior_model<float>();
  PriorObserver observer(model);
  for (int k = 0; k < 50; ++k) ASSERT_EQ(observer.step(0.5F), StepStatus::kOk);
  const auto variance = [&] { return observer.latent()[6]; };
  const float settled = variance();
  ASSERT_EQ(observer.step(kNaN), StepStatus::kHeld);
  EXPECT_GT(variance(), 1.05F * settled) << "process noise increases it, and no measurement reduces it";
  const float grown = variance();
  ASSERT_EQ(observer.step(0.5F), StepStatus::kOk);
  EXPECT_LT(variance(), grown) << "control: a measurement shrinks it";
  // A step over a gap ends with a measurement.
  const float before = variance();
  ASSERT_NE(observer.step(0.5F, 0.04F), StepStatus::kRejected);
  EXPECT_LT(variance(), 1.5F * before);
}

TEST(PriorObserver, WithoutUnitsItIsThePriorWhoseCorrectionsAreZero) {
  auto learned = testing::prior_model<double>();
  learned.correction.mlp = make_mlp<Activation::kTanh>(Dense<double, 9, 7>{});
  static const auto model = testing::filter_model<double>();
  static const auto same = learned;
  PriorObserver filter(model);
  PriorObserver prior(same);
  for (int k = 0; k < 400; ++k) {
    const double y = k % 37 == 5 ? static_cast<double>(kNaN) : 2.0 * std::sin(0.02 * k);
    const double dt_s = k % 11 == 3 ? 0.05 : 0.02;  // a missing measurement, and a gap
    ASSERT_EQ(filter.step(y, dt_s), prior.step(y, dt_s));
    for (int i = 0; i < 5; ++i) ASSERT_EQ(filter.latent()[i], prior.latent()[4 + i]) << k;  // exp(0) = 1 exactly
    for (int i = 0; i < 2; ++i) ASSERT_EQ(filter.estimate()[i], filter.latent()[i]);
  }
  EXPECT_GT(std::abs(filter.latent()[1]), 0.1) << "control: the filter has left its start";
  static_assert(sizeof(model) < sizeof(same) / 2);
}

TEST(DrivenKklObserver, AnExtremeInputIsNotUsed) {
  const auto model = driven_model<float>(Hold::kFirstOrder, Hold::kZeroOrder);
  DrivenKklObserver observer(model);
  ASSERT_EQ(observer.step({{1.0F}}, {{0.1F, 0.2F}}), StepStatus::kOk);
  const auto before = observer.latent();
  EXPECT_EQ(observer.step({{1.0F}}, {{3e38F, 3e38F}}), StepStatus::kDiverged);
  for (int r = 0; r < 3; ++r) EXPECT_EQ(observer.latent()[r], before[r]);
  EXPECT_EQ(observer.step({{1.0F}}, {{0.1F, 0.2F}}), StepStatus::kOk);
}

TEST(DrivenKklObserver, HoldsTheLastInputIfOneIsNotANumber) {
  const auto model = driven_model<float>(Hold::kFirstOrder, Hold::kZeroOrder);
  DrivenKklObserver observer(model), other(model);
  ASSERT_EQ(observer.step({{1.0F}}, {{0.5F, -1.0F}}), StepStatus::kOk);
  ASSERT_EQ(other.step({{1.0F}}, {{0.5F, -1.0F}}), StepStatus::kOk);
  EXPECT_EQ(observer.step({{1.2F}}, {{0.7F, kNaN}}), StepStatus::kHeld);
  EXPECT_EQ(other.step({{1.2F}}, {{0.7F, -1.0F}}), StepStatus::kOk);
  EXPECT_TRUE(testing::same_latent(observer.save(), other.save()));
  auto damaged = observer.save();
  damaged.input.u[1] = kInfinity;
  EXPECT_FALSE(observer.restore(damaged));
}

}  // namespace
}  // namespace nlo
