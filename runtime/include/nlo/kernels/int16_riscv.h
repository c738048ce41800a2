// SPDX-License-Identifier: MIT
// The block of int16.h on RISC-V: all rows of a layer. Weights lie input by input, those of all rows side by side.
// With vectors (V, or Zve32x) a strip of rows, 32 where a register has 128 bits, keeps its sums in v8-v15 while inputs
// stream by in scalar registers: VWMACC adds a product to each. Without them five rows are summed at a time.
#pragma once

#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/riscv_state.h"
#include "nlo/kernels/simd.h"

namespace nlo::kernels::int16 {

#if defined(NLO_RISCV_INTEGERS)

#define NLO_INPUT(offset, weights) \
  "lh t3, " offset                 \
  "(t1)\n"                         \
  "vle16.v " weights               \
  ", (t2)\n"                       \
  "add t2, t2, %[next_input]\n"    \
  "vwmacc.vx v8, t3, " weights "\n"

/// sums = bias + W in, kSize rows and as many pairs of inputs.
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

#else

/// kCount rows side by side, whose sums fit into registers.
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

}  // namespace nlo::kernels::int16
