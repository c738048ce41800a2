// SPDX-License-Identifier: MIT
// The block of int16.h on RISC-V, which holds all rows of a layer. Weights are stored input by input, with those of all
// rows side by side. With vectors (V, or Zve32x) the sums of a strip of rows (32 rows for registers of 128 bits) stay
// in v8-v15, inputs are in scalar registers, and VWMACC adds the products. Without vectors five rows are summed at a
// time.
#pragma once

#include <cstdint>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/riscv_state.h"
#include "nlo/kernels/simd.h"

namespace nlo::inline NLO_ISA::kernels::int16 {

#if defined(NLO_RISCV_INTEGERS)

#define NLO_INPUT(offset, weights) \
  "lh t3, " offset                 \
  "(t1)\n"                         \
  "vle16.v " weights               \
  ", (t2)\n"                       \
  "add t2, t2, %[next_input]\n"    \
  "vwmacc.vx v8, t3, " weights "\n"

/// sums = bias + W in for kSize rows and kPairCount pairs of inputs.
template <int kSize, int kPairCount>
NLO_INLINE void add_block(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                          std::int32_t (&sums)[kSize]) {
  long rows = kSize;
  std::int32_t* to = sums;
  asm volatile(
      "1:\n"
      "vsetvli t0, %[rows], e32, m8, ta, ma\n"
      "vle32.v v8, (%[bias])\n"
      "vsetvli zero, t0, e16, m4, ta, ma\n"
      "mv t1, %[in]\n"
      "mv t2, %[weights]\n"
      ".if %c[fours]\n"
      "2:\n" NLO_INPUT("0", "v16") NLO_INPUT("2", "v24") NLO_INPUT("4", "v16") NLO_INPUT("6", "v24")
      "addi t1, t1, 8\n"
      "bne t1, %[fours_end], 2b\n"
      ".endif\n"
      ".if %c[pair]\n" NLO_INPUT("0", "v16") NLO_INPUT("2", "v24")
      ".endif\n"
      "vsetvli zero, t0, e32, m8, ta, ma\n"
      "vse32.v v8, (%[to])\n"
      "sub %[rows], %[rows], t0\n"
      "slli t0, t0, 1\n"
      "add %[weights], %[weights], t0\n"
      "slli t0, t0, 1\n"
      "add %[bias], %[bias], t0\n"
      "add %[to], %[to], t0\n"
      "bnez %[rows], 1b\n"
      : [weights] "+r"(weights), [bias] "+r"(bias), [to] "+r"(to), [rows] "+r"(rows)
      : [in] "r"(in), [fours_end] "r"(in + kPairCount / 2 * 4), [next_input] "r"(2L * kSize), [fours] "i"(kPairCount / 2),
        [pair] "i"(kPairCount % 2)
      : "t0", "t1", "t2", "t3", NLO_RISCV_CLOBBERS);
}

#undef NLO_INPUT

/// True for the activations of int16.h that are implemented with vectors.
template <Activation kKind>
inline constexpr bool kActivatesRows = kKind == Activation::kTanh || kKind == Activation::kRelu;

// Stores a strip of t0 results in v0 to `out` and advances the pointers.
#define NLO_STORE_STRIP        \
  "vse16.v v0, (%[out])\n"     \
  "sub %[rows], %[rows], t0\n" \
  "slli t0, t0, 1\n"           \
  "add %[out], %[out], t0\n"   \
  "slli t0, t0, 1\n"           \
  "add %[sums], %[sums], t0\n" \
  "bnez %[rows], 1b\n"

/// out = activated<kKind, kShift>() of kN sums. table: the middle of the tanh table.
template <Activation kKind, int kShift, int kN>
NLO_INLINE void activate_rows(const std::int32_t* sums, std::int16_t* out, [[maybe_unused]] const std::int16_t* table) {
  long rows = kN;
  if constexpr (kKind == Activation::kRelu) {
    asm volatile(
        "1:\n"
        "vsetvli t0, %[rows], e32, m8, ta, ma\n"
        "vle32.v v8, (%[sums])\n"
        "vmax.vx v8, v8, zero\n"
        "vsra.vx v8, v8, %[shift]\n"
        "vmin.vx v8, v8, %[most]\n"
        "vsetvli zero, t0, e16, m4, ta, ma\n"
        "vnsrl.wi v0, v8, 0\n" NLO_STORE_STRIP
        : [sums] "+r"(sums), [out] "+r"(out), [rows] "+r"(rows)
        : [shift] "r"(kShift), [most] "r"(32767)
        : "t0", NLO_RISCV_CLOBBERS);
  } else {
    asm volatile(
        "1:\n"
        "vsetvli t0, %[rows], e32, m8, ta, ma\n"
        "vle32.v v8, (%[sums])\n"
        "vsra.vx v8, v8, %[shift]\n"
        "vmax.vx v8, v8, %[least]\n"
        "vmin.vx v8, v8, %[most]\n"
        "vsra.vi v16, v8, 11\n"
        "vadd.vx v16, v16, %[middle]\n"  // the middle of 513 entries, so that indices are not negative
        "vadd.vv v16, v16, v16\n"
        "vand.vx v8, v8, %[fraction]\n"
        "vsetvli zero, t0, e16, m4, ta, ma\n"
        "vluxei32.v v0, (%[table]), v16\n"
        "vluxei32.v v4, (%[next]), v16\n"
        "vwsub.vv v16, v4, v0\n"
        "vsetvli zero, t0, e32, m8, ta, ma\n"
        "vmul.vv v16, v16, v8\n"
        "vsetvli zero, t0, e16, m4, ta, ma\n"
        "vnsra.wi v4, v16, 11\n"
        "vadd.vv v0, v0, v4\n" NLO_STORE_STRIP
        : [sums] "+r"(sums), [out] "+r"(out), [rows] "+r"(rows)
        : [shift] "r"(kShift), [least] "r"(-(1 << 19)), [most] "r"((1 << 19) - 1), [middle] "r"(256),
          [fraction] "r"(2047), [table] "r"(table - 256), [next] "r"(table - 255)
        : "t0", NLO_RISCV_CLOBBERS);
  }
}
#undef NLO_STORE_STRIP

#else

template <Activation kKind>
inline constexpr bool kActivatesRows = false;

/// Sums kCount rows together; their sums fit into registers.
template <int kSize, int kPairCount, int kCount>
NLO_INLINE void add_rows(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                         std::int32_t* sums) {
  std::int32_t rows[kCount];
  NLO_UNROLL
  for (int r = 0; r < kCount; ++r) rows[r] = bias[r];
  for (int i = 0; i < 2 * kPairCount; ++i) {
    NLO_UNROLL
    for (int r = 0; r < kCount; ++r) rows[r] += weights[i * kSize + r] * in[i];
  }
  NLO_UNROLL
  for (int r = 0; r < kCount; ++r) sums[r] = rows[r];
}

template <int kSize, int kPairCount>
NLO_INLINE void add_block(const std::int16_t* weights, const std::int16_t* in, const std::int32_t* bias,
                          std::int32_t (&sums)[kSize]) {
  constexpr int kWhole = kSize / 5 * 5;
  for (int r = 0; r < kWhole; r += 5) add_rows<kSize, kPairCount, 5>(weights + r, in, bias + r, sums + r);
  if constexpr (kWhole < kSize) {
    add_rows<kSize, kPairCount, kSize - kWhole>(weights + kWhole, in, bias + kWhole, sums + kWhole);
  }
}

#endif

}  // namespace nlo::inline NLO_ISA::kernels::int16
