// SPDX-License-Identifier: MIT
// KklObserver: starts, steps over any time, saved and restored states.
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <type_traits>

#include "tests/runtime/testing.h"

namespace nlo {
namespace {

using testing::pair_model;
using testing::same_bits;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr auto kModel = pair_model<float>(Hold::kFirstOrder);
constexpr auto kSteadyModel = pair_model<float>(Hold::kFirstOrder, true);
constexpr auto kDoubleModel = pair_model<double>(Hold::kFirstOrder);
using Model = testing::PairModel<float>;
using Observer = KklObserver<Model>;
using DoubleObserver = KklObserver<testing::PairModel<double>>;

// Two ways to compute the coefficients of one step, with equal arguments, differ by a few rounding units of |z|, about
// 5.
constexpr double kRounding = 20 * std::numeric_limits<double>::epsilon() * 5;

// A pointer, z, y and three flags.
static_assert(sizeof(Observer::State) == 20);
static_assert(sizeof(Observer) <= 32);
static_assert(std::is_trivially_copyable_v<Observer::State>);
static_assert(std::is_trivially_destructible_v<Observer>);
static_assert(!std::is_constructible_v<Observer, Model>, "a temporary model would dangle");

// Evaluated at compile time: no undefined behaviour on this path, and observers can be `constinit`.
constexpr bool steps_at_compile_time() {
  Observer observer(kModel);
  bool good = observer.step(1.0F) == StepStatus::kOk && observer.latent()[0] == kModel.latent.initial[0];
  good = good && observer.step(2.0F) == StepStatus::kOk && observer.latent()[0] != kModel.latent.initial[0];
  good = good && observer.step(2.0F, 0.013F) == StepStatus::kOk;
  good = good && observer.step(2.0F, -1.0F) == StepStatus::kRejected;
  good = good && observer.step(11.0F) == StepStatus::kClamped && observer.save().y[0] == 10.0F;
  good = good && !observer.in_domain() && observer.step(kNan) == StepStatus::kHeld;
  good = good && observer.step_missed() == StepStatus::kStale && observer.in_domain();
  const auto saved = observer.save();
  observer.reset();
  good = good && observer.restore(saved) && observer.warm_start(1.0F) == StepStatus::kOk;
  for (const float z : observer.latent()) good = good && is_finite(z);
  return good;
}
static_assert(steps_at_compile_time());
constinit Observer global_observer{kModel};

TEST(KklObserver, IsAConstantInitialisedGlobal) {
  EXPECT_EQ(&global_observer.model(), &kModel);
  EXPECT_EQ(global_observer.latent()[2], -0.5F);
}

TEST(KklObserver, TheFirstMeasurementOnlyStartsIt) {
  Observer observer(kModel);
  EXPECT_EQ(observer.step(3.0F), StepStatus::kOk);
  for (int r = 0; r < 3; ++r) EXPECT_EQ(observer.latent()[r], kModel.latent.initial[r]);
  EXPECT_EQ(observer.save().y[0], 3.0F);
  EXPECT_EQ(observer.save().started, 1);
}

TEST(KklObserver, StartsInTheSteadyStateOfTheFirstMeasurementIfTheModelDeclaresIt) {
  Observer observer(kSteadyModel);
  EXPECT_EQ(observer.step(3.0F), StepStatus::kOk);
  for (int r = 0; r < 3; ++r) {
    EXPECT_FLOAT_EQ(observer.latent()[r], kModel.latent.initial[r] + 3.0F * kModel.latent.steady_gain[r][0]);
  }
}

TEST(KklObserver, StaysInTheSteadyStateOfAConstant) {
  auto model = kDoubleModel;
  for (double& z : model.latent.initial) z = 0.0;
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder, Hold::kRk4}) {
    model.latent.hold = hold;
    testing::complete(model);
    DoubleObserver observer(model);
    ASSERT_EQ(observer.warm_start(2.5), StepStatus::kOk);
    const auto z0 = observer.latent();
    for (int k = 0; k < 1000; ++k) ASSERT_EQ(observer.step(2.5), StepStatus::kOk);
    for (int r = 0; r < 3; ++r) {
      EXPECT_NEAR(observer.latent()[r], 2.5 * model.latent.steady_gain[r][0], 100 * kRounding)
          << static_cast<int>(hold);
      EXPECT_NEAR(observer.latent()[r], z0[r], 100 * kRounding);
    }
  }
}

TEST(KklObserver, WarmStartForgetsThePast) {
  Observer used(kModel), fresh(kModel);
  for (int k = 0; k < 50; ++k) ASSERT_EQ(used.step(0.1F * static_cast<float>(k)), StepStatus::kOk);
  (void)used.step(kNan);
  ASSERT_EQ(used.warm_start(1.5F), StepStatus::kOk);
  ASSERT_EQ(fresh.warm_start(1.5F), StepStatus::kOk);
  EXPECT_TRUE(same_bits(used.save(), fresh.save()));
}

TEST(KklObserver, WarmStartOnABadMeasurementChangesOnlyTheFlags) {
  Observer observer(kModel);
  for (int k = 0; k < 50; ++k) ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
  const auto before = observer.save();
  EXPECT_EQ(observer.warm_start(kNan), StepStatus::kHeld);
  EXPECT_TRUE(testing::same_latent(before, observer.save()));
  EXPECT_EQ(observer.warm_start(99.0F), StepStatus::kClamped);
  EXPECT_EQ(observer.save().y[0], 10.0F);
}

TEST(KklObserver, ResetForgetsThePast) {
  Observer observer(kModel);
  const auto fresh = observer.save();
  for (const float y : {1.0F, 99.0F, kNan, kNan, kNan, kNan}) (void)observer.step(y);
  EXPECT_FALSE(same_bits(observer.save(), fresh));
  observer.reset();
  EXPECT_TRUE(same_bits(observer.save(), fresh));
}

TEST(KklObserver, ResetToAGivenStateContinuesFromIt) {
  Observer observer(kModel);
  ASSERT_TRUE(observer.reset({{1.0F, 2.0F, 3.0F}}, {{4.0F}}));
  float z[3] = {1.0F, 2.0F, 3.0F};
  const float y0[1] = {4.0F}, y1[1] = {5.0F};
  advance<1>(kModel.latent.step, z, y0, y1);
  ASSERT_EQ(observer.step(5.0F), StepStatus::kOk);
  for (int r = 0; r < 3; ++r) EXPECT_EQ(observer.latent()[r], z[r]);
}

TEST(KklObserver, ResetRefusesValuesThatAreNotFiniteOrOutOfRange) {
  Observer observer(kModel);
  ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
  const auto before = observer.save();
  EXPECT_FALSE(observer.reset({{1.0F, kNan, 3.0F}}, {{4.0F}}));
  EXPECT_FALSE(observer.reset({{1.0F, 2.0F, 3.0F}}, {{kNan}}));
  EXPECT_FALSE(observer.reset({{1.0F, 2.0F, 3.0F}}, {{10.5F}}));
  EXPECT_FALSE(observer.reset({{3e38F, 3e38F, 0.0F}}, {{1.0F}}));  // so large a pair overflows when it rotates
  EXPECT_TRUE(same_bits(observer.save(), before));
}

TEST(KklObserver, StepEqualsAStepOverTheSamplePeriod) {
  for (const Hold hold : {Hold::kZeroOrder, Hold::kFirstOrder}) {
    const auto model = pair_model<double>(hold);
    DoubleObserver plain(model), timed(model);
    for (int k = 0; k < 500; ++k) {
      const double y = std::sin(0.05 * k);
      ASSERT_EQ(plain.step(y), StepStatus::kOk);
      ASSERT_EQ(timed.step(y, model.sample_period_s), StepStatus::kOk);
    }
    for (int r = 0; r < 3; ++r) EXPECT_NEAR(plain.latent()[r], timed.latent()[r], kRounding);
  }
}

TEST(KklObserver, TheDomainOfARelativeOutputAppliesToZMinusItsSteadyState) {
  for (const bool relative : {true, false}) {
    auto model = testing::pair_model<double>(Hold::kFirstOrder, true);
    model.latent.relative[0] = relative;
    KklObserver observer{model};
    ASSERT_EQ(observer.step(9.0), StepStatus::kOk);  // S y = (2.2, 8.1, 4.5); the range of z is +-5
    EXPECT_EQ(observer.in_domain(), relative);
  }
}

TEST(KklObserver, TwoHalfStepsEqualOneStepOnARamp) {
  DoubleObserver whole(kDoubleModel), halves(kDoubleModel);
  ASSERT_EQ(whole.step(-1.0), StepStatus::kOk);
  ASSERT_EQ(halves.step(-1.0), StepStatus::kOk);
  for (int k = 1; k <= 100; ++k) {
    const double y = -1.0 + 0.08 * k, middle = y - 0.04;
    ASSERT_EQ(whole.step(y, 0.02), StepStatus::kOk);
    ASSERT_EQ(halves.step(middle, 0.01), StepStatus::kOk);
    ASSERT_EQ(halves.step(y, 0.01), StepStatus::kOk);
  }
  for (int r = 0; r < 3; ++r) EXPECT_NEAR(whole.latent()[r], halves.latent()[r], 10 * kRounding);
}

TEST(KklObserver, BridgesAGapOnARampInOneStep) {
  DoubleObserver stepped(kDoubleModel), bridged(kDoubleModel);
  ASSERT_EQ(stepped.step(0.0), StepStatus::kOk);
  ASSERT_EQ(bridged.step(0.0), StepStatus::kOk);
  for (int k = 1; k <= 40; ++k) ASSERT_EQ(stepped.step(0.1 * k), StepStatus::kOk);
  ASSERT_EQ(bridged.step(4.0, 40 * kDoubleModel.sample_period_s), StepStatus::kStale) << "39 samples were missed";
  for (int r = 0; r < 3; ++r) EXPECT_NEAR(stepped.latent()[r], bridged.latent()[r], 10 * kRounding);
}

TEST(KklObserver, UsesTheExactRampForIrregularStepsOfAnRk4Model) {
  const auto rk4 = pair_model<double>(Hold::kRk4);
  DoubleObserver observer(rk4), exact(kDoubleModel);
  for (int k = 0; k < 10; ++k) {  // lambda dt = -10: the Runge-Kutta polynomial would be 291
    ASSERT_EQ(observer.step(1.0 * k, 5.0), k == 0 ? StepStatus::kOk : StepStatus::kStale);
    ASSERT_EQ(exact.step(1.0 * k, 5.0), k == 0 ? StepStatus::kOk : StepStatus::kStale);
  }
  EXPECT_TRUE(same_bits(observer.save(), exact.save()));
}

TEST(KklObserver, RefusesCorruptedStates) {
  Observer observer(kModel);
  ASSERT_EQ(observer.step(1.0F), StepStatus::kOk);
  const auto good = observer.save();
  const auto refused = [&](auto damage) {
    auto state = good;
    damage(state);
    const bool accepted = observer.restore(state);
    return !accepted && same_bits(observer.save(), good);
  };
  const float inf = std::numeric_limits<float>::infinity();
  for (const float bad : {kNan, inf, -inf, 3e38F, -3e38F}) {
    for (int r = 0; r < 3; ++r) EXPECT_TRUE(refused([&](auto& s) { s.z[r] = bad; })) << bad;
    EXPECT_TRUE(refused([&](auto& s) { s.y[0] = bad; })) << bad;
  }
  EXPECT_TRUE(refused([](auto& s) { s.y[0] = 10.001F; }));
  EXPECT_TRUE(refused([](auto& s) { s.started = 2; }));
  EXPECT_TRUE(refused([](auto& s) { s.started = 0; }));  // y is only known after the start
  EXPECT_TRUE(refused([](auto& s) { s.status = static_cast<StepStatus>(8); }));
  EXPECT_FALSE(refused([](auto&) {}));  // control: the unchanged state is accepted
}

TEST(KklObserver, ResumesAnUnstartedState) {
  Observer observer(kModel), other(kModel);
  ASSERT_EQ(other.step(3.0F), StepStatus::kOk);
  ASSERT_TRUE(other.restore(observer.save()));
  EXPECT_TRUE(same_bits(other.save(), observer.save()));
}

TEST(KklObserver, FlushesALatentStateThatWouldStaySubnormal) {
  Observer observer(kModel);
  ASSERT_TRUE(observer.reset({{1.0F, 1.0F, 1.0F}}, {{0.0F}}));
  for (int k = 0; k < 20000; ++k) {
    ASSERT_EQ(observer.step(0.0F), StepStatus::kOk);
    for (const float z : observer.latent()) ASSERT_TRUE(z == 0.0F || std::fabs(z) >= 0x1p-100F);
  }
  for (const float z : observer.latent()) EXPECT_EQ(z, 0.0F);
}

TEST(KklObserver, ReportsTheDomainOfTraining) {
  Observer observer(kModel);
  for (int r = 0; r < 3; ++r) {
    Observer::Latent z{{0.0F, 0.0F, 0.0F}};
    for (const auto& [value, inside] :
         {std::pair{5.0F, true}, {std::nextafter(5.0F, 6.0F), false}, {-5.0F, true}, {-5.1F, false}}) {
      z[r] = value;
      ASSERT_TRUE(observer.reset(z, {{0.0F}}));
      EXPECT_EQ(observer.in_domain(), inside) << r << ' ' << value;
    }
  }
}

TEST(KklObserver, EstimatesFromTheLatentStateAndTheLatestOutput) {
  auto model = testing::angle_model<float>();
  KklObserver<testing::AngleModel<float>> observer(model);
  ASSERT_TRUE(observer.reset({{1.0F, 2.0F, 3.0F, 4.0F}}, {{0.5F, 0.25F}}));
  const auto x_hat = observer.estimate();
  EXPECT_FLOAT_EQ(x_hat[0], 0.5F);  // unit DC gain of the pair: S = (1, 0)
  EXPECT_FLOAT_EQ(x_hat[1], 2.0F);
  EXPECT_FLOAT_EQ(x_hat[2], 2.5F);
  EXPECT_FLOAT_EQ(x_hat[3], 4.0F);
}

}  // namespace
}  // namespace nlo
