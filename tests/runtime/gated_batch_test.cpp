// SPDX-License-Identifier: MIT
// A batch of gated observers against as many single ones: what comes out is the same, fault by fault.
#include <nlo/gated_batch.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <type_traits>
#include <vector>

#include "bench/random_structures.h"
#include "tests/runtime/testing.h"

namespace nlo {
namespace {

constexpr int kUnits = 13;

constexpr auto model() {
  auto m = bench::random_gated_model<kUnits>();
  m.outputs.min[0] = -1.0F;  // to be clamped to
  m.outputs.max[0] = 1.0F;
  return m;
}

/// Good measurements, missed ones, ones out of range, late first ones.
float measurement(std::mt19937& random, int sample, int plant) {
  if (sample < plant % 4) return std::numeric_limits<float>::quiet_NaN();
  const float draw = testing::uniform<float>(random, -1, 1);
  return draw > 0.95F ? 5.0F : draw < -0.95F ? std::numeric_limits<float>::quiet_NaN() : 0.9F * draw;
}

/// The largest difference of z and x_hat from those of single observers of `other`; statuses must be theirs.
template <int kPlants, Arithmetic kArithmetic, class Model>
float off(const Model& batched, const Model& other) {
  GatedBatch<Model, kPlants, kArithmetic> batch{batched};
  std::vector<GatedObserver<Model, kArithmetic>> observers(kPlants, GatedObserver<Model, kArithmetic>{other});
  std::mt19937 random(7);
  float worst_off = 0;
  for (int sample = 0; sample < 60; ++sample) {
    float y[1][kPlants], x_hat[2][kPlants];
    // Now and then all plants are well, which takes the quick way.
    for (int n = 0; n < kPlants; ++n)
      y[0][n] = sample % 3 == 2 ? 0.1F * static_cast<float>(n % 9) - 0.4F : measurement(random, sample, n);
    const StepStatus status = batch.step(y);
    StepStatus worst = StepStatus::kOk;
    batch.estimate(x_hat);
    for (int n = 0; n < kPlants; ++n) {
      auto& observer = observers[static_cast<std::size_t>(n)];
      worst = std::max(worst, observer.step(y[0][n]));
      EXPECT_EQ(batch.status(n), observer.status()) << "plant " << n << ", sample " << sample;
      const auto want = observer.estimate();
      for (int r = 0; r < kUnits; ++r)
        worst_off = std::max(worst_off, std::abs(batch.latent(n)[r] - observer.latent()[r]));
      for (int i = 0; i < 2; ++i) worst_off = std::max(worst_off, std::abs(x_hat[i][n] - want[i]));
    }
    EXPECT_EQ(status, worst) << sample;
  }
  return worst_off;
}

constexpr auto kModel = model();

TEST(GatedBatch, AnswersAsAnObserverPerPlantWould) {
  constexpr float kOtherOrder = 2e-5F;  // sums of some 14 terms below 3 in another order, and z remembers them
  EXPECT_LE((off<1, Arithmetic::kFast>(kModel, kModel)), kOtherOrder);
  EXPECT_LE((off<32, Arithmetic::kFast>(kModel, kModel)), kOtherOrder);
  EXPECT_LE((off<45, Arithmetic::kFast>(kModel, kModel)), kOtherOrder);
}

TEST(GatedBatch, GivesTheBitsOfTheDeterministicObserver) {
  EXPECT_EQ((off<32, Arithmetic::kDeterministic>(kModel, kModel)), 0.0F);
  EXPECT_EQ((off<45, Arithmetic::kDeterministic>(kModel, kModel)), 0.0F);
}

TEST(GatedBatch, ControlAnotherBiasOfOneGateIsSeen) {
  auto other = kModel;
  other.gates.mlp.layer.bias[2] += 1e-2F;
  EXPECT_GT((off<32, Arithmetic::kFast>(kModel, other)), 1e-4F);
}

TEST(GatedBatch, BeginsAPlantAnewWhoseZIsSpoilt) {
  testing::UpsetBatch<GatedBatch<std::remove_cvref_t<decltype(kModel)>, 32>> batch{kModel};
  float y[1][32];
  for (float& value : y[0]) value = 0.2F;
  for (int k = 0; k < 4; ++k) ASSERT_EQ(batch.step(y), StepStatus::kOk);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -3e38}) {
    batch.spoil_z(2, 7, bad);
    EXPECT_EQ(batch.step(y), StepStatus::kReset);
    for (int plant = 0; plant < 32; ++plant)
      EXPECT_EQ(batch.status(plant), plant == 7 ? StepStatus::kReset : StepStatus::kOk) << plant;
    GatedObserver fresh{kModel};
    ASSERT_EQ(batch.step(y), StepStatus::kOk);
    ASSERT_EQ(fresh.step(0.2F), StepStatus::kOk);
    for (int r = 0; r < kUnits; ++r) EXPECT_NEAR(batch.latent(7)[r], fresh.latent()[r], 2e-5F);
  }
}

TEST(GatedBatch, TakesAPlantInAndLetsItOut) {
  GatedObserver observer{kModel};
  for (const float y : {0.1F, 0.2F, 0.3F}) ASSERT_EQ(observer.step(y), StepStatus::kOk);
  GatedBatch<std::remove_cvref_t<decltype(kModel)>, 3> batch{kModel};
  ASSERT_TRUE(batch.restore(1, observer.save()));
  for (int r = 0; r < kUnits; ++r) EXPECT_EQ(batch.latent(1)[r], observer.latent()[r]);
  auto damaged = observer.save();
  damaged.z[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(batch.restore(1, damaged));
}

}  // namespace
}  // namespace nlo
