// SPDX-License-Identifier: MIT
// A program for any x86-64 that asks the CPU computes what one compiled for that CPU does, bit for bit: networks, their
// batches with the recurrence of z, their forward-mode products, errors' deviations and gated units.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "tests/runtime/instruction_set_run.h"

namespace nlo {
namespace {

using instruction_set::Bits;
namespace x86 = kernels::x86;

template <class Values>
bool same(const Values& a, const Values& b) {
  return std::memcmp(&a, &b, sizeof(Values)) == 0;
}

TEST(Dispatch, GivesTheBitsOfTheCpusInstructionSet) {
  const Bits ours = testing::run_networks();
  const bool avx512 = x86::has_avx512(x86::level());
  const Bits native = avx512 ? instruction_set::bits_of_avx512() : instruction_set::bits_of_avx2();
  EXPECT_TRUE(same(ours.estimate, native.estimate));
  EXPECT_TRUE(same(ours.jvp, native.jvp));
  EXPECT_TRUE(same(ours.silu_jvp, native.silu_jvp));
  EXPECT_TRUE(same(ours.batch, native.batch));
  EXPECT_TRUE(same(ours.log2_sigma, native.log2_sigma));
  EXPECT_TRUE(same(ours.gated, native.gated));
  EXPECT_TRUE(same(ours.latent, native.latent));
}

/// By the code for AVX2, whatever more the CPU has.
Bits run_avx2() {
  constexpr auto& kMlp = testing::InstructionSetModel<Activation::kTanh>::kModel.inverse_map.mlp;
  constexpr auto& kSilu = testing::InstructionSetModel<Activation::kSilu>::kModel.inverse_map.mlp;
  using Mlp = std::remove_cvref_t<decltype(kMlp)>;
  constexpr int kBlock = kernels::kBatchBlock<float, 32>;
  Bits bits{};
  LayerBuffer<float, Mlp::kWidest * kBlock> ping, pong;
  JvpBuffer<float, Mlp::kWidest> jvp_here, jvp_there;
  testing::for_each_round([&](int round, const float(&in)[3], const float(&direction)[3]) {
    x86::evaluate_avx2<Activation::kTanh, Arithmetic::kFast>(kMlp, in, bits.estimate[round], ping.values, pong.values);
    x86::jvp_avx2<Activation::kTanh>(kMlp, in, direction, bits.jvp[round], jvp_here, jvp_there);
    x86::jvp_avx2<Activation::kSilu>(kSilu, in, direction, bits.silu_jvp[round], jvp_here, jvp_there);
  });
  for (int first = 0; first < instruction_set::kPlants; first += kBlock) {
    float in[3 * kBlock] = {}, out[2 * kBlock];
    for (int n = 0; n < kBlock; ++n)
      for (int r = 0; r < 3; ++r)
        in[r * kBlock + n] = 0.05F * static_cast<float>(first + n + 1) - static_cast<float>(r);
    x86::evaluate_batch_avx2<Activation::kTanh, Arithmetic::kFast, kBlock>(kMlp, in, out, ping.values, pong.values);
    for (int n = 0; n < kBlock && first + n < instruction_set::kPlants; ++n)
      for (int i = 0; i < 2; ++i) bits.batch[i][first + n] = out[i * kBlock + n];
  }
  constexpr auto& kModel = testing::InstructionSetModel<Activation::kTanh>::kModel;
  float kept[1][instruction_set::kWholeBlocks] = {}, y[1][instruction_set::kWholeBlocks];
  for (int n = 0; n < instruction_set::kWholeBlocks; ++n) {
    const auto state = testing::begun(KklObserver{kModel}.save(), n);
    for (int r = 0; r < 3; ++r) bits.latent[r][n] = state.z[r];
  }
  for (int round = 0; round < instruction_set::kRounds; ++round) {
    for (int n = 0; n < instruction_set::kWholeBlocks; ++n) y[0][n] = testing::measured(round, n);
    for (int first = 0; first < instruction_set::kWholeBlocks; first += kBlock)
      EXPECT_TRUE((x86::kkl_plants_avx2<Arithmetic::kFast, kBlock>(kModel, Vector<const float*, 1>{{y[0]}}, first,
                                                                   bits.latent, kept)));
  }
  return bits;
}

TEST(Dispatch, GivesTheBitsOfAvx2WhereThatIsAll) {
  const Bits ours = run_avx2(), native = instruction_set::bits_of_avx2();
  EXPECT_TRUE(same(ours.estimate, native.estimate));
  EXPECT_TRUE(same(ours.jvp, native.jvp));
  EXPECT_TRUE(same(ours.silu_jvp, native.silu_jvp));
  EXPECT_TRUE(same(ours.batch, native.batch));
  EXPECT_TRUE(same(ours.latent, native.latent));
}

/// Estimates and products, by the code for CPUs of one load of 64 bytes a cycle and for the others.
template <Activation kKind>
void run_one_and_two_loads(Bits& one, Bits& two) {
  constexpr auto& kMlp = testing::InstructionSetModel<kKind>::kModel.inverse_map.mlp;
  using Mlp = std::remove_cvref_t<decltype(kMlp)>;
  LayerBuffer<float, Mlp::kWidest> ping, pong;
  JvpBuffer<float, Mlp::kWidest> jvp_here, jvp_there;
  testing::for_each_round([&](int round, const float(&in)[3], const float(&direction)[3]) {
    x86::evaluate_one_load<kKind, Arithmetic::kFast>(kMlp, in, one.estimate[round], ping.values, pong.values);
    x86::evaluate_avx512<kKind, Arithmetic::kFast>(kMlp, in, two.estimate[round], ping.values, pong.values);
    x86::jvp_one_load<kKind>(kMlp, in, direction, one.jvp[round], jvp_here, jvp_there);
    x86::jvp_avx512<kKind>(kMlp, in, direction, two.jvp[round], jvp_here, jvp_there);
  });
}

TEST(Dispatch, GivesTheSameSumsHoweverManyWideLoadsTheCpuHas) {
  if (!x86::has_avx512(x86::level())) GTEST_SKIP() << "no registers of 64 bytes";
  Bits one{}, two{};
  run_one_and_two_loads<Activation::kRelu>(one, two);
  EXPECT_TRUE(same(one.estimate, two.estimate));
  EXPECT_TRUE(same(one.jvp, two.jvp));
  run_one_and_two_loads<Activation::kTanh>(one, two);  // whose tanh is awaited or not, by the CPU
  for (int round = 0; round < instruction_set::kRounds; ++round)
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR(one.estimate[round][i], two.estimate[round][i], 1e-6F);
      EXPECT_NEAR(one.jvp[round][i], two.jvp[round][i], 1e-6F);
    }
}

TEST(Dispatch, TheBitsTellInstructionSetsApart) {  // the control of the tests above
  if (!x86::has_avx512(x86::level())) GTEST_SKIP() << "one instruction set alone";
  const Bits avx2 = instruction_set::bits_of_avx2(), avx512 = instruction_set::bits_of_avx512();
  EXPECT_FALSE(same(avx2.estimate, avx512.estimate));
  EXPECT_FALSE(same(avx2.jvp, avx512.jvp));
  EXPECT_FALSE(same(avx2.log2_sigma, avx512.log2_sigma));
  EXPECT_FALSE(same(avx2.gated, avx512.gated));
}

TEST(Dispatch, ControlOneObserverHasOtherBitsThanTheBatch) {  // its z is stepped by what the compiler was told of
  static constexpr auto& kModel = testing::InstructionSetModel<Activation::kTanh>::kModel;
  const Bits ours = testing::run_networks();
  float farthest = 0.0F;
  for (int n = 0; n < instruction_set::kWholeBlocks; ++n) {
    KklObserver observer{kModel};
    ASSERT_TRUE(observer.restore(testing::begun(observer.save(), n)));
    for (int round = 0; round < instruction_set::kRounds; ++round) (void)observer.step(testing::measured(round, n));
    for (int r = 0; r < 3; ++r) farthest = std::max(farthest, std::fabs(observer.latent()[r] - ours.latent[r][n]));
  }
  EXPECT_GT(farthest, 0.0F);
  EXPECT_LE(farthest, 5e-6F);  // 20 samples of a z of at most 2, two roundings of 1.2e-7 each
}

TEST(Dispatch, TakesBatchesOfAnySize) {
  constexpr auto& kMap = testing::InstructionSetModel<Activation::kTanh>::kModel.inverse_map;
  float in[3 * 6], out[2 * 6];
  for (int i = 0; i < 3 * 6; ++i) in[i] = 0.1F * static_cast<float>(i);
  evaluate_batch<Arithmetic::kFast, 6>(kMap, in, out);
  for (int n = 0; n < 6; ++n) {
    const float one_in[3] = {in[n], in[6 + n], in[12 + n]};
    float one_out[2];
    kMap.evaluate(one_in, one_out);
    for (int i = 0; i < 2; ++i) EXPECT_EQ(out[i * 6 + n], one_out[i]);
  }
}

}  // namespace
}  // namespace nlo
