// SPDX-License-Identifier: MIT
// The int16 kernels: assembly equals plain C++ for each block size and number of pairs, and whole observers give the
// bits of tests/golden with each compiler and core.
#include <cstdint>

#include "bench/random_quantised_model.h"
#include "tests/embedded/target/text.h"

namespace nlo::target {
namespace {

bool good = true;

alignas(4) std::int16_t weights[2 * 5 * 64], placed[2 * 5 * 64], in[2 * 64];

template <int kSize, int kPairCount>
void check_block(bench::RandomUniform& random, Hash& hash) {
  const auto any = [&random] {
    random();
    return static_cast<std::int16_t>(random.state >> 16);
  };
  for (int i = 0; i < 2 * kSize * kPairCount; ++i) weights[i] = static_cast<std::int16_t>(any() / (2 * kPairCount));
  for (int i = 0; i < 2 * kPairCount; ++i) in[i] = any() == -32768 ? 0 : any();
  std::int32_t bias[kSize], plain[kSize], fast[kSize];
  for (std::int32_t& b : bias) b = any() * 16384;
  for (int r = 0; r < kSize; ++r) {
    for (int i = 0; i < 2 * kPairCount; ++i) {
      placed[kernels::int16::block_position(kPairCount, kSize, r, i)] =
          weights[kernels::int16::pair_position(kSize, r, i)];
    }
  }
  kernels::int16::add_block_plain<kSize, kPairCount>(placed, in, bias, plain);
  kernels::int16::add_block<kSize, kPairCount>(placed, in, bias, fast);
  for (int r = 0; r < kSize; ++r) {
    hash.add(static_cast<std::uint32_t>(plain[r]));
    if (plain[r] != fast[r]) {
      good = false;
      board::write("the assembly differs from its plain version\n");
    }
  }
}

void check_blocks() {
  bench::RandomUniform random{1};
  Hash hash;
  for (int trial = 0; trial < 50; ++trial) {
    [&]<int... kCount>(std::integer_sequence<int, kCount...>) {
      (check_block<4, kCount + 1>(random, hash), ...);
      (check_block<5, kCount + 1>(random, hash), ...);
    }
    (std::make_integer_sequence<int, 12>{});
    check_block<5, 25>(random, hash);
    check_block<4, 63>(random, hash);
  }
  Hash other;  // hash of block sizes that not every core has
  [&]<int kFew>(std::integer_sequence<int, kFew>) {
    if constexpr (kernels::int16::Blocks<kFew>::kWhole > 0) {
      check_block<1, 12>(random, other);
      check_block<2, 25>(random, other);
      check_block<kFew, 1>(random, other);
    }
  }(std::integer_sequence<int, 3>{});
  board::write("blocks ");
  hash.write();
}

template <class Model>
void run(const char* name, const Model& model) {
  SampledObserver<Model, Arithmetic::kDeterministic> observer{model};
  bench::RandomUniform random{2};
  Hash hash;
  for (int k = 0; k < 2000; ++k) {
    if (observer.step(rounded(8.0F * random())) != StepStatus::kOk) good = false;
    for (const float x : observer.estimate()) hash.add(x);
  }
  board::write(name);
  hash.write();
}

constexpr auto kPaper = bench::random_quantised_model<Activation::kTanh, 50, 4>();
constexpr auto kRelu = bench::random_quantised_model<Activation::kRelu, 50, 4>();
constexpr auto kSmall = bench::random_quantised_model<Activation::kTanh, 16, 2>();
constexpr auto kSilu = bench::random_quantised_model<Activation::kSilu, 16, 2>();
constexpr auto kGated = bench::random_quantised_gated_model<16>();
constexpr auto kOdd = bench::random_quantised_model<Activation::kTanh, 7, 2>();

}  // namespace

int run_all() {
  check_blocks();
  run("tanh 50x4 ", kPaper);
  run("relu 50x4 ", kRelu);
  run("tanh 16x2 ", kSmall);
  run("tanh 7x2 ", kOdd);
  run("silu 16x2 ", kSilu);
  run("gated 16 ", kGated);
  return good ? 0 : 1;
}

}  // namespace nlo::target

int main() {
  return nlo::target::run_all();
}
