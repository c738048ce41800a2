// SPDX-License-Identifier: MIT
// Assembly kernels of Cortex-M and of RISC-V vectors give the bits of their plain C++ version, and that version gives
// the same bits on the core as on the host: hashes to compare with tests/golden. The lines "fused" come from machines
// with fused multiply-add.
#include <nlo/kernels/cortex_m.h>
#include <nlo/kernels/cortex_m_gates.h>
#include <nlo/kernels/cortex_m_vectors.h>
#include <nlo/kernels/riscv_vectors.h>

#include <cstdint>
#include <iterator>
#include <utility>

#include "bench/random_model.h"
#include "tests/embedded/target/text.h"

namespace nlo::target {
namespace {

using namespace kernels::cortex_m;

bool good = true;

float weights[50 * 50], bias[50], in[50];

constexpr float kSpecial[] = {0.0F,  -0.0F, 1e-45F, -1e-38F, 1e-20F, 7.75F,  -7.75F,
                              7.76F, 8.0F,  1e6F,   -1e6F,   1e30F,  -1e30F, 0.5F};

[[maybe_unused]] bool same_bits(const float* a, const float* b, int count) {
  for (int i = 0; i < count; ++i) {
    if (std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i])) return false;
  }
  return true;
}

template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut>
void check(Hash& hash) {
  // A guard before and after the output: the kernel must not write there.
  constexpr float kGuard = 12345.0F;
  bench::RandomUniform random{kIn * 100 + kOut};
  for (int trial = 0; trial < 20; ++trial) {
    const float scale = trial % 4 == 3 ? 40.0F : 1.0F;  // also saturated activations
    for (int i = 0; i < kIn * kOut; ++i) weights[i] = rounded(scale * random());
    for (int o = 0; o < kOut; ++o) bias[o] = random();
    for (int i = 0; i < kIn; ++i) in[i] = random();
    if (trial % 3 == 2) in[trial % kIn] = kSpecial[trial % static_cast<int>(std::size(kSpecial))];
    float plain[kOut];
    layer_plain<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, plain);
    for (const float x : plain) hash.add(x);
#if defined(NLO_RISCV_VECTORS)
    layer_plain<kKind, kArithmetic, kLast, kIn, kOut, false>(weights, bias, in,
                                                             plain);  // plain versions without a table of tanh
#endif
#if defined(NLO_CORTEX_M_FLOAT) || defined(NLO_RISCV_VECTORS)
    float guarded[kOut + 2];
    guarded[0] = guarded[kOut + 1] = kGuard;
    const auto is_plain = [&] {
      const bool same = guarded[0] == kGuard && guarded[kOut + 1] == kGuard && same_bits(plain, guarded + 1, kOut);
      for (int o = 0; o < kOut; ++o) guarded[o + 1] = 0.0F;
      return same;
    };
    bool same = true;
#if defined(NLO_CORTEX_M_FLOAT)
    layer<kKind, kArithmetic, kLast, kIn, kOut>(weights, bias, in, guarded + 1);
    same = is_plain();
#endif
#if defined(NLO_CORTEX_M_MVE) || defined(NLO_RISCV_VECTORS)
#if defined(NLO_CORTEX_M_MVE)
    namespace vectors = kernels::cortex_m_vectors;
#else
    namespace vectors = kernels::riscv_vectors;
#endif
    float by_vectors[50 * 52]{}, padded_bias[52]{};
    for (int o = 0; o < kOut; ++o) {
      padded_bias[o] = bias[o];
      for (int i = 0; i < kIn; ++i)
        by_vectors[vectors::weight_position<kIn, kOut>(o, i)] = weights[weight_position<kIn, kOut>(o, i)];
    }
    vectors::layer<kKind, kArithmetic, kLast, kIn, kOut>(by_vectors, padded_bias, in, guarded + 1);
    same = is_plain() && same;
#endif
    if (!same) {
      good = false;
      board::write("the assembly differs from its plain version: ");
      board::write(std::uint32_t{kIn});
      board::write(" -> ");
      board::write(std::uint32_t{kOut});
      board::write("\n");
    }
#else
    static_cast<void>(kGuard);
#endif
  }
}

template <Activation kKind, Arithmetic kArithmetic, int kIn, int kOut>
void check_both(Hash& hash) {
  check<kKind, kArithmetic, false, kIn, kOut>(hash);
  check<kKind, kArithmetic, true, kIn, kOut>(hash);
}

/// Checks numbers of inputs that are multiples of five and others, and each block size.
template <Activation kKind, Arithmetic kArithmetic>
void run(const char* name) {
  Hash hash;
  check_both<kKind, kArithmetic, 3, 50>(hash);
  check_both<kKind, kArithmetic, 50, 50>(hash);
  [&]<int... kOut>(std::integer_sequence<int, kOut...>) {
    (check_both<kKind, kArithmetic, 1 + kOut % 12, 1 + kOut>(hash), ...);
  }
  (std::make_integer_sequence<int, 14>{});
  check_both<kKind, kArithmetic, 17, 27>(hash);
  board::write(name);
  hash.write();
}

/// The gates of kN units, followed by a guard.
template <Arithmetic kArithmetic, int kN>
void check_gates(Hash& hash) {
  bench::RandomUniform random{kN};
  for (int trial = 0; trial < 20; ++trial) {
    float t[kN], target[kN], z[kN + 1], plain[kN + 1];
    for (int i = 0; i < kN; ++i) {
      t[i] = trial % 4 == 3 ? (random() < 0.0F ? -1.0F : 1.0F) : random();
      target[i] = random();
      z[i] = trial % 5 == 4 ? 0.0F : random();
    }
    z[kN] = plain[kN] = 12345.0F;
    reset_units_plain<kArithmetic, kN>(t, z, plain);
    for (int i = 0; i < kN; ++i) hash.add(plain[i]);
#if defined(NLO_CORTEX_M_GATES)
    constexpr bool kFused = kArithmetic == Arithmetic::kFast && kFuses;
    float gated[kN + 1];
    gated[kN] = 12345.0F;
    reset_units<kFused, kN>(t, z, gated);
    bool same = same_bits(gated, plain, kN + 1);
    float copy[kN + 1];
    copy[kN] = 12345.0F;
    same = copy_below_2<kN>(z, copy) && same && same_bits(copy, z, kN + 1);
    copy[trial % kN] = trial % 2 == 0 ? -2.0F : std::bit_cast<float>(0x7fc00000U);
    same = same && !copy_below_2<kN>(copy, gated);
    for (int i = 0; i <= kN; ++i) copy[i] = z[i];
    move_units<kFused, kN>(t, target, copy);
    move_units_plain<kArithmetic, kN>(t, target, z);
    if (!same || !same_bits(copy, z, kN + 1)) {
      good = false;
      board::write("the assembly of gates differs from its plain version: ");
      board::write(std::uint32_t{kN});
      board::write("\n");
    }
#else
    move_units_plain<kArithmetic, kN>(t, target, z);
#endif
    for (int i = 0; i < kN; ++i) hash.add(z[i]);
  }
}

/// Numbers of units that are and are not multiples of eight and five.
template <Arithmetic kArithmetic>
void run_gates(const char* name) {
  Hash hash;
  [&]<int... kLess>(std::integer_sequence<int, kLess...>) {
    (check_gates<kArithmetic, 1 + kLess>(hash), ...);
  }
  (std::make_integer_sequence<int, 12>{});
  check_gates<kArithmetic, 32>(hash);
  board::write(name);
  hash.write();
}

}  // namespace

int run_all() {
  run<Activation::kTanh, Arithmetic::kDeterministic>("deterministic tanh ");
  run<Activation::kRelu, Arithmetic::kDeterministic>("deterministic relu ");
  run<Activation::kSilu, Arithmetic::kDeterministic>("deterministic silu ");
  run_gates<Arithmetic::kDeterministic>("deterministic gates ");
#if !defined(NLO_ON_BOARD) || defined(__ARM_FEATURE_FMA) || defined(__riscv_flen)
  run<Activation::kTanh, Arithmetic::kFast>("fused tanh ");
  run<Activation::kRelu, Arithmetic::kFast>("fused relu ");
  run<Activation::kSilu, Arithmetic::kFast>("fused silu ");
  run_gates<Arithmetic::kFast>("fused gates ");
#endif
  return good ? 0 : 1;
}

}  // namespace nlo::target

int main() {
  return nlo::target::run_all();
}
