// SPDX-License-Identifier: MIT
// Compares a batch of gated observers with as many single observers: the results are equal, also after each kind of
// fault.
#include <nlo/gated_batch.h>

#include <gtest/gtest.h>

#include <limits>
#include <type_traits>

#include "bench/random_structures.h"
#include "tests/runtime/batch_twin.h"

namespace nlo {
namespace {

constexpr int kUnits = 13;

constexpr auto model() {
  auto m = bench::random_gated_model<kUnits>();
  m.outputs.min[0] = -1.0F;  // a narrow range, so that readings are clamped
  m.outputs.max[0] = 1.0F;
  return m;
}

/// Largest difference to single observers of `other`.
template <int kPlants, Arithmetic kArithmetic, class Model>
float off(const Model& batched, const Model& other) {
  return testing::off_observers<kPlants>(GatedBatch<Model, kPlants, kArithmetic>{batched},
                                         GatedObserver<Model, kArithmetic>{other}, testing::AnyMeasurement{});
}

constexpr auto kModel = model();

TEST(GatedBatch, EqualsOneObserverPerPlant) {
  constexpr float kOtherOrder = 2e-5F;  // sums of about 14 terms below 3 in another order, which z accumulates
  EXPECT_LE((off<1, Arithmetic::kFast>(kModel, kModel)), kOtherOrder);
  EXPECT_LE((off<32, Arithmetic::kFast>(kModel, kModel)), kOtherOrder);
  EXPECT_LE((off<45, Arithmetic::kFast>(kModel, kModel)), kOtherOrder);
}

TEST(GatedBatch, GivesTheBitsOfTheDeterministicObserver) {
  EXPECT_EQ((off<32, Arithmetic::kDeterministic>(kModel, kModel)), 0.0F);
  EXPECT_EQ((off<45, Arithmetic::kDeterministic>(kModel, kModel)), 0.0F);
}

TEST(GatedBatch, ControlAnotherBiasOfOneGateIsDetected) {
  auto other = kModel;
  other.gates.mlp.layer.bias[2] += 1e-2F;
  EXPECT_GT((off<32, Arithmetic::kFast>(kModel, other)), 1e-4F);
}

TEST(GatedBatch, RestartsAPlantWithACorruptedZ) {
  testing::UpsetBatch<GatedBatch<std::remove_cvref_t<decltype(kModel)>, 32>> batch{kModel};
  float y[1][32];
  for (float& value : y[0]) value = 0.2F;
  for (int k = 0; k < 4; ++k) ASSERT_EQ(batch.step(y), StepStatus::kOk);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -3e38}) {
    batch.corrupt_z(2, 7, bad);
    EXPECT_EQ(batch.step(y), StepStatus::kReset);
    for (int plant = 0; plant < 32; ++plant)
      EXPECT_EQ(batch.status(plant), plant == 7 ? StepStatus::kReset : StepStatus::kOk) << plant;
    GatedObserver fresh{kModel};
    ASSERT_EQ(batch.step(y), StepStatus::kOk);
    ASSERT_EQ(fresh.step(0.2F), StepStatus::kOk);
    for (int r = 0; r < kUnits; ++r) EXPECT_NEAR(batch.latent(7)[r], fresh.latent()[r], 2e-5F);
  }
}

TEST(GatedBatch, ExchangesAPlantWithASingleObserver) {
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
