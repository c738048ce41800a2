// SPDX-License-Identifier: MIT
// A batch of plants compared with as many single observers: the results are equal, also after each kind of fault.
#include <nlo/kkl_batch.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <type_traits>

#include "bench/random_model.h"
#include "tests/runtime/batch_twin.h"

namespace nlo {
namespace {

/// The random observer of the benchmarks, with a narrow range so that readings are clamped.
template <Activation kKind>
constexpr auto model() {
  auto m = bench::random_kkl_model<kKind, 20, 2>();
  m.outputs.min[0] = -1.0F;
  m.outputs.max[0] = 1.0F;
  return m;
}

template <int kPlants, Arithmetic kArithmetic>
float off() {
  static constexpr auto kModel = model<Activation::kTanh>();
  using Model = std::remove_cvref_t<decltype(kModel)>;
  return testing::off_observers<kPlants>(KklBatch<Model, kPlants, kArithmetic>{kModel},
                                         KklObserver<Model, kArithmetic>{kModel}, testing::AnyMeasurement{});
}

TEST(KklBatch, EqualsOneObserverPerPlant) {
  constexpr float kOtherOrder = 2e-5F;  // sums of about 20 terms below 3 in another order, through three layers
  EXPECT_LE((off<1, Arithmetic::kFast>()), kOtherOrder);
  EXPECT_LE((off<7, Arithmetic::kFast>()), kOtherOrder);
  EXPECT_LE((off<32, Arithmetic::kFast>()), kOtherOrder);
  EXPECT_LE((off<45, Arithmetic::kFast>()), kOtherOrder);
}

TEST(KklBatch, GivesTheBitsOfTheDeterministicObserver) {
  EXPECT_EQ((off<32, Arithmetic::kDeterministic>()), 0.0F);
  EXPECT_EQ((off<45, Arithmetic::kDeterministic>()), 0.0F);
}

TEST(KklBatch, ExchangesAPlantWithASingleObserver) {
  static constexpr auto kModel = model<Activation::kRelu>();
  using Model = std::remove_cvref_t<decltype(kModel)>;
  KklObserver<Model> observer{kModel};
  for (const float y : {0.1F, 0.2F, 0.3F}) ASSERT_EQ(observer.step(y), StepStatus::kOk);
  KklBatch<Model, 3> batch{kModel};
  ASSERT_TRUE(batch.restore(1, observer.save()));
  for (int r = 0; r < 3; ++r) EXPECT_EQ(batch.latent(1)[r], observer.latent()[r]);
  auto damaged = observer.save();
  damaged.z[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(batch.restore(1, damaged));
  EXPECT_EQ(batch.latent(1)[0], observer.latent()[0]);
  batch.reset();
  EXPECT_EQ(batch.save(1).started, 0);
}

/// 32 plants after four samples of y = 0.2.
template <class Model>
auto resting_batch(const Model& model) {
  testing::UpsetBatch<KklBatch<Model, 32>> batch{model};
  float y[1][32];
  for (float& value : y[0]) value = 0.2F;
  for (int k = 0; k < 4; ++k) EXPECT_EQ(batch.step(y), StepStatus::kOk);
  return batch;
}

TEST(KklBatch, OnlyAPlantWithACorruptedZOrYLeavesItsDomainAndRestarts) {
  static constexpr auto kModel = model<Activation::kTanh>();
  float y[1][32];
  for (float& value : y[0]) value = 0.2F;
  for (const bool of_z : {true, false}) {
    auto batch = resting_batch(kModel);
    EXPECT_TRUE(batch.in_domain(7));
    of_z ? batch.corrupt_z(1, 7, std::numeric_limits<double>::quiet_NaN()) : batch.corrupt_y(0, 7, 3e38);
    EXPECT_FALSE(batch.in_domain(7));
    EXPECT_EQ(batch.step(y), StepStatus::kReset);
    for (int plant = 0; plant < 32; ++plant)
      EXPECT_EQ(batch.status(plant), plant == 7 ? StepStatus::kReset : StepStatus::kOk) << plant;
  }
}

TEST(KklBatch, APlantFarFromTrainingIsOutOfItsDomain) {
  static constexpr auto kModel = model<Activation::kTanh>();
  auto batch = resting_batch(kModel);
  batch.corrupt_z(0, 3, 1e6);
  EXPECT_FALSE(batch.in_domain(3));
  EXPECT_TRUE(batch.in_domain(4));
}

TEST(KklBatch, FlushesSubnormalZ) {
  static constexpr auto kModel = model<Activation::kTanh>();
  auto batch = resting_batch(kModel);
  for (int r = 0; r < 3; ++r) {
    batch.corrupt_z(r, 3, 1e-36);
    batch.corrupt_z(r, 4, -1e-36);
  }
  for (const int plant : {3, 4}) batch.corrupt_y(0, plant, 0.0);
  float y[1][32];
  for (int plant = 0; plant < 32; ++plant) y[0][plant] = plant == 3 || plant == 4 ? 0.0F : 0.2F;
  ASSERT_EQ(batch.step(y), StepStatus::kOk);
  for (int r = 0; r < 3; ++r) {
    EXPECT_EQ(batch.latent(3)[r], 0.0F);
    EXPECT_EQ(batch.latent(4)[r], 0.0F);
    EXPECT_NE(batch.latent(5)[r], 0.0F) << "control";
  }
}

TEST(KklBatch, StepsAnglesThroughTheirWrap) {
  auto turning = model<Activation::kTanh>();
  turning.outputs.wrap[0] = 1.5F;
  KklObserver observer{turning};
  KklBatch<decltype(turning), 2> batch{turning};
  for (int k = 0; k < 40; ++k) {
    const float angle = static_cast<float>(std::remainder(0.11 * k, 1.5));
    const float y[1][2] = {{angle, 0.0F}};
    ASSERT_EQ(batch.step(y), observer.step(angle));
    for (int r = 0; r < 3; ++r) ASSERT_EQ(batch.latent(0)[r], observer.latent()[r]) << k;
  }
}

}  // namespace
}  // namespace nlo
