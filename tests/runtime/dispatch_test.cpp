// SPDX-License-Identifier: MIT
// With NLO_CPU_DISPATCH, a program computes at each level the bits of code that is compiled for that instruction set:
// networks, batches with the recurrence of z, forward-mode products, error heads and gated units. The test selects each
// level that this CPU can execute.
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

/// Runs the networks with the code of one level, whichever level the CPU would get.
Bits bits_of_level(x86::Level level) {
  const int before = x86::level_in_use;
  x86::level_in_use = static_cast<int>(level);
  const Bits bits = testing::run_networks();
  x86::level_in_use = before;
  return bits;
}

void expect_same(const Bits& ours, const Bits& compiled) {
  EXPECT_TRUE(same(ours.estimate, compiled.estimate));
  EXPECT_TRUE(same(ours.jvp, compiled.jvp));
  EXPECT_TRUE(same(ours.silu_jvp, compiled.silu_jvp));
  EXPECT_TRUE(same(ours.batch, compiled.batch));
  EXPECT_TRUE(same(ours.log2_sigma, compiled.log2_sigma));
  EXPECT_TRUE(same(ours.gated, compiled.gated));
  EXPECT_TRUE(same(ours.latent, compiled.latent));
}

TEST(Dispatch, GivesTheBitsOfCodeCompiledForAnyX86) {
  expect_same(bits_of_level(x86::Level::kBaseline), instruction_set::bits_of_baseline());
}

TEST(Dispatch, GivesTheBitsOfCodeCompiledForAvx2) {
  expect_same(bits_of_level(x86::Level::kAvx2), instruction_set::bits_of_avx2());
}

TEST(Dispatch, GivesTheBitsOfCodeCompiledForAvx512) {
  if (!x86::has_avx512(x86::ask_cpu())) GTEST_SKIP() << "this CPU has no AVX-512";
  expect_same(bits_of_level(x86::Level::kAvx512), instruction_set::bits_of_avx512());
  expect_same(bits_of_level(x86::Level::kAvx512), instruction_set::bits_of_avx512_one_load());
}

TEST(Dispatch, GivesTheBitsOfCodeCompiledForAvx512WithOneWideLoad) {
  if (!x86::has_avx512(x86::ask_cpu())) GTEST_SKIP() << "this CPU has no AVX-512";
  expect_same(bits_of_level(x86::Level::kAvx512OneLoad), instruction_set::bits_of_avx512());
  expect_same(bits_of_level(x86::Level::kAvx512OneLoad), instruction_set::bits_of_avx512_one_load());
}

TEST(Dispatch, ChoosesTheLevelThatTheCpuHas) {
  (void)testing::run_networks();
  EXPECT_EQ(x86::level_in_use, static_cast<int>(x86::ask_cpu()));
  EXPECT_NE(x86::ask_cpu(), x86::Level::kUnknown);
}

void expect_different(const Bits& one, const Bits& other) {
  EXPECT_FALSE(same(one.estimate, other.estimate));
  EXPECT_FALSE(same(one.jvp, other.jvp));
  EXPECT_FALSE(same(one.log2_sigma, other.log2_sigma));
  EXPECT_FALSE(same(one.gated, other.gated));
}

TEST(Dispatch, ControlTheBitsDifferBetweenInstructionSets) {  // otherwise the equal bits above would prove nothing
  expect_different(instruction_set::bits_of_baseline(), instruction_set::bits_of_avx2());
  if (x86::has_avx512(x86::ask_cpu()))
    expect_different(instruction_set::bits_of_avx2(), instruction_set::bits_of_avx512());
}

TEST(Dispatch,
     ControlASingleObserverGivesOtherBitsThanABatch) {  // z of a single observer uses the instructions of the build
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
  EXPECT_LE(farthest, 5e-6F);  // 20 samples of z up to 2, with two roundings of 1.2e-7 each
}

TEST(Dispatch, SupportsBatchesOfAnySize) {
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
