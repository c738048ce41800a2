// SPDX-License-Identifier: MIT
// A model that saturates z: within its reach the estimate equals that of T* bit for bit; beyond, that of the edge; the
// transition is continuous; batches agree.
#include <nlo/kkl_batch.h>
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <type_traits>

#include "tests/runtime/batch_twin.h"

namespace nlo {
namespace {

/// Returns `base` with the same fields and a reach.
template <Saturation kSaturation, class Scalar, int kNx, int kNy, int kNz, int kPairs, class Map>
auto saturating(const KklModel<Scalar, kNx, kNy, kNz, kPairs, Map>& base, double reach) {
  KklModel<Scalar, kNx, kNy, kNz, kPairs, Map, 0, Hold::kZeroOrder, 0, kSaturation> m{};
  m.sample_period_s = base.sample_period_s;
  m.stale_after = base.stale_after;
  m.latent = base.latent;
  m.outputs = base.outputs;
  m.domain = base.domain;
  m.inverse_map = base.inverse_map;
  for (int r = 0; r < kNz; ++r) {
    m.reach.min[r] = static_cast<Scalar>(-reach);
    m.reach.max[r] = static_cast<Scalar>(reach * (r + 1));  // each coordinate has its own limits
    if constexpr (kSaturation == Saturation::kRelativeLatent) m.reach.steady_gain[0][r] = m.latent.steady_gain[r][0];
  }
  return m;
}

/// Returns an observer of the model with these z and y.
template <Arithmetic kArithmetic, class Model, class Scalar, int kNz>
KklObserver<Model, kArithmetic> at(const Model& model, const Scalar (&z)[kNz], const Scalar (&y)[Model::kNr]) {
  KklObserver<Model, kArithmetic> observer(model);
  auto state = observer.save();
  for (int r = 0; r < kNz; ++r) state.z[r] = z[r];
  for (int j = 0; j < Model::kNr; ++j) state.y[j] = y[j];
  state.started = 1;
  EXPECT_TRUE(observer.restore(state));
  return observer;
}

template <class Scalar, Arithmetic kArithmetic>
void expect_closed_form() {
  const auto base = testing::pair_model<Scalar>(Hold::kFirstOrder);
  const auto model = saturating<Saturation::kLatent>(base, 2.0);
  std::mt19937 random(3);
  int outside = 0;
  for (int k = 0; k < 500; ++k) {
    Scalar z[3], y[1] = {Scalar(1)};
    const double size = k % 50 == 0 ? 1e25 : 5.0;
    for (Scalar& value : z) value = testing::uniform<Scalar>(random, -size, size);
    const auto x_hat = at<kArithmetic>(model, z, y).estimate();  // T* = identity
    for (int r = 0; r < 3; ++r) {
      const Scalar want = std::clamp(z[r], Scalar(-2), Scalar(2 * (r + 1)));
      outside += want != z[r];
      ASSERT_EQ(x_hat[r], want);
    }
  }
  EXPECT_GT(outside, 400) << "control: z left the box";
}

TEST(Saturation, LimitsEachCoordinateToItsBoxForAnyZ) {
  expect_closed_form<float, Arithmetic::kFast>();
  expect_closed_form<float, Arithmetic::kDeterministic>();
  expect_closed_form<double, Arithmetic::kFast>();
  expect_closed_form<double, Arithmetic::kDeterministic>();
}

template <class Scalar, Arithmetic kArithmetic>
void expect_relative_closed_form() {
  const auto base = testing::angle_model<Scalar>();
  const auto model = saturating<Saturation::kRelativeLatent>(base, 0.5);
  const double rounding = std::is_same_v<Scalar, float> ? 1e-6 : 1e-14;  // some units in the last place of 5
  std::mt19937 random(4);
  int inside = 0;
  for (int k = 0; k < 500; ++k) {
    Scalar z[4], relative[4];
    const Scalar y[2] = {testing::uniform<Scalar>(random, -3, 3), testing::uniform<Scalar>(random, -1, 1)};
    const double size = k % 2 == 0 ? 0.45 : 1.5;
    for (int r = 0; r < 4; ++r) {
      relative[r] = testing::uniform<Scalar>(random, -size, size);
      z[r] = relative[r] + model.latent.steady_gain[r][0] * y[0];  // only the angle is relative
    }
    const auto limited = at<kArithmetic>(model, z, y).estimate(), free = at<kArithmetic>(base, z, y).estimate();
    for (int r = 0; r < 4; ++r) {  // T* = z - S angle
      const Scalar want = std::clamp(relative[r], Scalar(-0.5), Scalar(0.5 * (r + 1)));
      ASSERT_NEAR(limited[r], want, rounding);
      if (k % 2 == 0) {
        ++inside;
        ASSERT_EQ(limited[r], free[r]) << "equal bits within reach";
      }
    }
  }
  EXPECT_EQ(inside, 1000);
}

TEST(Saturation, AppliesToZMinusTheSteadyStateOfAnglesAndIsExactWithinReach) {
  expect_relative_closed_form<float, Arithmetic::kFast>();
  expect_relative_closed_form<float, Arithmetic::kDeterministic>();
  expect_relative_closed_form<double, Arithmetic::kFast>();
  expect_relative_closed_form<double, Arithmetic::kDeterministic>();
}

/// The part of a model that saturate() reads.
template <class Scalar, int kNz>
struct Reach {
  static constexpr Saturation kSaturation = Saturation::kRelativeLatent;
  LatentReach<Scalar, kNz, 2, kSaturation> reach;
};

template <class Scalar, int kNz, Arithmetic kArithmetic>
void expect_relative_box() {
  Reach<Scalar, kNz> model{};
  for (int r = 0; r < kNz; ++r) {
    model.reach.min[r] = static_cast<Scalar>(-0.5 - r);
    model.reach.max[r] = static_cast<Scalar>(0.25 * (r + 1));
    model.reach.steady_gain[0][r] = static_cast<Scalar>(r - 1.5);
    model.reach.steady_gain[1][r] = static_cast<Scalar>(2.0 - 0.5 * r);
  }
  const double rounding = std::is_same_v<Scalar, float> ? 2e-6 : 4e-15;  // some units in the last place of 10
  std::mt19937 random(7);
  for (int k = 0; k < 200; ++k) {
    const Scalar y[2] = {testing::uniform<Scalar>(random, -2, 2), testing::uniform<Scalar>(random, -2, 2)};
    Scalar z[kNz], saturated[kNz];
    for (Scalar& value : z) value = testing::uniform<Scalar>(random, -8, 8);
    saturate<kArithmetic>(model, y, z, saturated);
    for (int r = 0; r < kNz; ++r) {
      const Scalar rest = model.reach.steady_gain[0][r] * y[0] + model.reach.steady_gain[1][r] * y[1];
      const Scalar want = rest + std::clamp(z[r] - rest, model.reach.min[r], model.reach.max[r]);
      ASSERT_NEAR(saturated[r], want, rounding) << "coordinate " << r << " of " << kNz;
    }
  }
}

TEST(Saturation,
     LimitsToTheRelativeBoxForAnyNumberOfCoordinates) {  // less than a vector, whole vectors, and a remainder
  expect_relative_box<float, 1, Arithmetic::kFast>();
  expect_relative_box<float, 3, Arithmetic::kFast>();
  expect_relative_box<float, 3, Arithmetic::kDeterministic>();
  expect_relative_box<float, 4, Arithmetic::kFast>();
  expect_relative_box<float, 7, Arithmetic::kDeterministic>();
  expect_relative_box<double, 1, Arithmetic::kFast>();
  expect_relative_box<double, 5, Arithmetic::kDeterministic>();
}

TEST(Saturation, TheEstimateIsContinuousAndConstantBeyondTheEdge) {
  const auto model = saturating<Saturation::kLatent>(testing::pair_model<double>(Hold::kFirstOrder), 2.0);
  constexpr double kStep = 1e-3;
  double last = -2.0;
  for (double value = -8.0; value < 8.0; value += kStep) {
    const double z[3] = {value, 0.0, 0.0}, y[1] = {0.0};
    const double now = at<Arithmetic::kFast>(model, z, y).estimate()[0];
    ASSERT_GE(now, last);
    ASSERT_LE(now - last, kStep * (1.0 + 1e-9));
    last = now;
  }
  EXPECT_EQ(last, 2.0);
}

TEST(Saturation, DoesNotAffectSteps) {
  const auto base = testing::pair_model<float>(Hold::kFirstOrder);
  const auto model = saturating<Saturation::kLatent>(base, 0.1);
  KklObserver limited(model);
  KklObserver free(base);
  std::mt19937 random(5);
  bool differed = false;
  for (int k = 0; k < 200; ++k) {
    const float y = testing::uniform<float>(random, -8, 8);
    ASSERT_EQ(limited.step(y), free.step(y));
    ASSERT_TRUE(testing::same_bits(limited.save(), free.save()));
    ASSERT_EQ(limited.in_domain(), free.in_domain()) << "the domain is that of training, not the reach of T*";
    differed = differed || limited.estimate()[0] != free.estimate()[0];
  }
  EXPECT_TRUE(differed) << "control";
}

template <Saturation kSaturation, Arithmetic kArithmetic, class Base>
float batch_off_observers(const Base& base) {
  constexpr int kPlants = 19;
  const auto model = saturating<kSaturation>(base, 0.3);
  using Model = std::remove_cvref_t<decltype(model)>;
  return testing::off_observers<kPlants>(KklBatch<Model, kPlants, kArithmetic>{model},
                                         KklObserver<Model, kArithmetic>{model}, testing::AnyMeasurement{});
}

TEST(Saturation, ABatchEqualsSingleObservers) {
  const auto pair = testing::pair_model<float>(Hold::kFirstOrder);
  const auto angle = testing::angle_model<float>();
  EXPECT_EQ((batch_off_observers<Saturation::kLatent, Arithmetic::kDeterministic>(pair)), 0.0F);
  EXPECT_EQ((batch_off_observers<Saturation::kRelativeLatent, Arithmetic::kDeterministic>(angle)), 0.0F);
  constexpr float kOtherOrder = 1e-5F;  // another order of sums
  EXPECT_LE((batch_off_observers<Saturation::kLatent, Arithmetic::kFast>(pair)), kOtherOrder);
  EXPECT_LE((batch_off_observers<Saturation::kRelativeLatent, Arithmetic::kFast>(angle)), kOtherOrder);
}

}  // namespace
}  // namespace nlo
