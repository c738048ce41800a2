// SPDX-License-Identifier: MIT
// Outputs that may be missing: they fade to their rest value, T* reads their staleness, and other channels are not
// affected.
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>
#include <nlo/sensor_failures.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/runtime/batch_twin.h"

namespace nlo {
namespace {

constexpr double kGone = std::numeric_limits<double>::quiet_NaN();
constexpr double kFlightStep_s = 0.05, kStaleness_s = 0.2, kRest = 3.0;

/// Two outputs with a mode of unit gain each; the second may be missing and rests at 3. T* = z.
template <class Scalar>
using Failing = KklModel<Scalar, 2, 2, 2, 0, decltype(testing::identity_map<Scalar, 2>()), 0, Hold::kZeroOrder, 1>;

template <class Scalar>
Failing<Scalar> failing_model(bool starts_steady = false) {
  Failing<Scalar> m{};
  m.sample_period_s = Scalar(kFlightStep_s);
  m.stale_after = 3;
  m.latent.hold = Hold::kFirstOrder;
  m.latent.starts_steady = starts_steady;
  for (int j = 0; j < 2; ++j) {
    m.latent.eigenvalues[j] = Scalar(-2 - j);
    m.latent.output_injection[j][j] = Scalar(2 + j);
    m.outputs.min[j] = Scalar(-10);
    m.outputs.max[j] = Scalar(10);
    m.domain.latent_min[j] = Scalar(-20);
    m.domain.latent_max[j] = Scalar(20);
  }
  m.outputs.max[2] = Scalar(1);
  m.failures = {{1}, {Scalar(kRest)}, Scalar(1.0 / kStaleness_s), Scalar(std::exp(-kFlightStep_s / kStaleness_s))};
  m.inverse_map = testing::identity_map<Scalar, 2>();
  testing::complete(m);
  return m;
}

TEST(SensorFailures, AMissingOutputFadesToItsRestValueByTheClosedForm) {
  const auto model = failing_model<double>();
  KklObserver observer(model);
  ASSERT_EQ(observer.step({{1.0, -2.0}}), StepStatus::kOk);
  EXPECT_EQ(observer.staleness(1), 0.0);
  double time_s = 0.0;
  for (int k = 0; k < 30; ++k) {
    const bool irregular = k % 4 == 3;
    const double dt_s = irregular ? 0.13 : kFlightStep_s;
    time_s += dt_s;
    const StepStatus status = irregular ? observer.step({{1.0, kGone}}, dt_s) : observer.step({{1.0, kGone}});
    ASSERT_EQ(status, StepStatus::kHeld) << "never stale, because the output may be missing";
    const double left = std::exp(-time_s / kStaleness_s);
    ASSERT_NEAR(observer.save().y[1], kRest + left * (-2.0 - kRest), 1e-13);
    ASSERT_NEAR(observer.staleness(1), 1.0 - left, 1e-14);
    ASSERT_EQ(observer.staleness(0), 0.0);
  }
  const double stale = observer.staleness(1);
  ASSERT_EQ(observer.step({{1.0, 4.0}}), StepStatus::kOk);
  EXPECT_EQ(observer.save().y[1], 4.0);
  EXPECT_NEAR(observer.staleness(1), stale * std::exp(-kFlightStep_s / kStaleness_s), 1e-15);
}

TEST(SensorFailures, OutputsFailIndependently) {
  // Outputs 2 and 0 of three may fail, in this order; their rest values are 3 and -1. Each is missing at other times.
  const SensorFailures<double, 2> failures{{2, 0}, {kRest, -1.0}, 1.0 / kStaleness_s, 0.75};
  double last[5] = {1.0, 5.0, -2.0, 0.25, 0.5};  // outputs, stalenesses of 2 and of 0
  for (int k = 0; k < 8; ++k) {
    const double keep = k % 3 == 0 ? 0.75 : 0.5;
    Vector<double, 5> readings{{0.5 * k, 7.0, -1.5 * k, 9.0, 9.0}};
    double want[5] = {readings[0], 7.0, readings[2], 0.0, 0.0};
    for (int i = 0; i < 2; ++i) {
      const int output = i == 0 ? 2 : 0;
      const bool missing = k >> i & 1;
      if (missing) {
        readings[output] = i == 0 ? kGone : std::numeric_limits<double>::infinity();
        want[output] = (1.0 - keep) * (i == 0 ? kRest : -1.0) + keep * last[output];
      }
      want[3 + i] = missing ? 1.0 - keep + keep * last[3 + i] : keep * last[3 + i];
    }
    const Vector<bool, 2> missing = failures.fill<Arithmetic::kFast>(readings, last, keep);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(missing[i], (k >> i & 1) != 0) << k;
    for (int r = 0; r < 5; ++r) {
      EXPECT_NEAR(readings[r], want[r], 1e-14) << "reading " << r << " of sample " << k;
      last[r] = readings[r];
    }
  }
}

TEST(SensorFailures, AReadingFadesCompletelyIfRateTimesGapOverflows) {
  auto model = failing_model<float>();
  model.failures.rate = 3.3e38F;  // a staleness of 3e-39 s, which validation refuses
  KklObserver observer(model);
  ASSERT_EQ(observer.step({{1.0F, -2.0F}}), StepStatus::kOk);
  EXPECT_EQ(observer.step({{1.0F, std::numeric_limits<float>::quiet_NaN()}}, 40.0F), StepStatus::kStale);
  EXPECT_EQ(observer.status(1), StepStatus::kHeld) << "this output may be missing";
  EXPECT_EQ(observer.save().y[1], float(kRest));
  EXPECT_EQ(observer.staleness(1), 1.0F);
  EXPECT_EQ(observer.step({{1.0F, 4.0F}}, 40.0F), StepStatus::kStale);
  EXPECT_EQ(observer.staleness(1), 0.0F);
}

TEST(SensorFailures, OtherOutputsAreNotAffected) {
  const auto model = failing_model<double>();
  KklObserver whole(model), broken(model);
  for (int k = 0; k < 50; ++k) {
    const double y = std::sin(0.2 * k);
    ASSERT_EQ(whole.step({{y, 1.0}}), StepStatus::kOk);
    ASSERT_EQ(broken.step({{y, k < 10 ? 1.0 : kGone}}), k < 10 ? StepStatus::kOk : StepStatus::kHeld);
    ASSERT_EQ(whole.latent()[0], broken.latent()[0]);
  }
  EXPECT_GT(std::fabs(whole.latent()[1] - broken.latent()[1]), 1.0)
      << "control: the mode of the missing output changes";
}

TEST(SensorFailures, OnlyASensorThatMayFailMayBeMissingAtTheStart) {
  for (const bool steady : {false, true}) {
    const auto model = failing_model<double>(steady);
    KklObserver observer(model);
    EXPECT_EQ(observer.step({{kGone, 1.0}}), StepStatus::kHeld);
    EXPECT_EQ(observer.save().started, 0);
    EXPECT_EQ(observer.step({{1.0, kGone}}), StepStatus::kHeld);
    EXPECT_EQ(observer.save().started, 1);
    EXPECT_EQ(observer.save().y[1], kRest);
    EXPECT_EQ(observer.staleness(1), 1.0);
    EXPECT_EQ(observer.latent()[1], steady ? kRest : 0.0);
  }
  const auto model = failing_model<double>();
  KklObserver observer(model);
  EXPECT_EQ(observer.warm_start({{1.0, kGone}}), StepStatus::kHeld);
  EXPECT_EQ(observer.latent()[1], kRest);
}

TEST(SensorFailures, AnotherMissingSensorStillBecomesStale) {
  const auto model = failing_model<double>();
  KklObserver observer(model);
  ASSERT_EQ(observer.step({{1.0, 1.0}}), StepStatus::kOk);
  EXPECT_EQ(observer.step({{kGone, kGone}}), StepStatus::kHeld);
  EXPECT_EQ(observer.step({{kGone, 1.0}}), StepStatus::kHeld);
  EXPECT_EQ(observer.step({{kGone, kGone}}), StepStatus::kStale);
  EXPECT_EQ(observer.step({{50.0, kGone}}), StepStatus::kOutOfRange);
  EXPECT_EQ(observer.step({{1.0, 1.0}}), StepStatus::kOk);
  EXPECT_EQ(observer.step({{50.0, kGone}}), StepStatus::kHeld) << "held is worse than clamped";
}

TEST(SensorFailures, RefusesAStateWithAnImpossibleStaleness) {
  const auto model = failing_model<float>();
  KklObserver observer(model);
  ASSERT_EQ(observer.step({{1.0F, std::numeric_limits<float>::quiet_NaN()}}), StepStatus::kHeld);
  auto state = observer.save();
  ASSERT_TRUE(observer.restore(state));
  state.y[2] = 1.5F;
  EXPECT_FALSE(observer.restore(state));
}

template <Arithmetic kArithmetic>
float batch_off_observers() {
  constexpr int kPlants = 19;
  static const auto model = failing_model<float>();
  using Model = std::remove_cvref_t<decltype(model)>;
  std::mt19937 random(5);
  return testing::off_observers<kPlants>(KklBatch<Model, kPlants, kArithmetic>{model},
                                         KklObserver<Model, kArithmetic>{model}, [&](int k, int n, int channel) {
                                           const double most = k % 2 == 0 ? 0.5 : 5.0;
                                           return channel == 1 && k % 10 > 6 && n % 3 == 0
                                                      ? std::numeric_limits<float>::quiet_NaN()
                                                      : testing::uniform<float>(random, -most, most);
                                         });
}

TEST(SensorFailures, ABatchEqualsSingleObservers) {
  EXPECT_EQ(batch_off_observers<Arithmetic::kDeterministic>(), 0.0F);
  EXPECT_LE(batch_off_observers<Arithmetic::kFast>(), 1e-5F);  // sums in another order
}

}  // namespace
}  // namespace nlo
