// SPDX-License-Identifier: MIT
// Matrix-vector product of a dense layer in float32 for Cortex-M cores with vectors of floats (MVE: M55, M85).
//
// There are 8 vectors of four values. The sums of a tile of up to 24 outputs stay in q0-q5. Inputs are loaded into core
// registers, two at a time, and weights into q6 and q7. Weights are stored in the order in which they are read; outputs
// are padded with zeros to whole vectors. On layers of 50 this takes 0.6 instructions per multiply-add; cortex_m.h:
// 1.1.
//
// fast           VFMA by a scalar
// deterministic  VMUL by a scalar, VADD: each operation rounded by itself, as on every other target
//
// The order of the sums, and therefore the bits, are those of cortex_m::layer_plain().
#pragma once

#include <bit>
#include <cstdint>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/cortex_m.h"
#include "nlo/kernels/simd.h"

#if defined(NLO_CORTEX_M_FLOAT) && defined(__ARM_FEATURE_MVE)
#if (__ARM_FEATURE_MVE & 2) != 0
#define NLO_CORTEX_M_MVE 1
#endif
#endif

#if defined(NLO_CORTEX_M_MVE)

namespace nlo::inline NLO_ISA::kernels::cortex_m_vectors {

/// Divides the outputs into vectors of four, and the vectors into tiles.
template <int kOut>
using Tiles = cortex_m::Parts<(kOut + 3) / 4, 6>;

/// Returns the position of the weight of input i for output o: tile by tile, then input by input.
template <int kIn, int kOut>
constexpr int weight_position(int o, int i) {
  using T = Tiles<kOut>;
  const int tile = T::part_of(o / 4);
  return 4 * (T::first(tile) * kIn + i * T::size(tile)) + (o - 4 * T::first(tile));
}

// sum += factor * x, x in a core register or a vector: fused, or rounded twice.
#define NLO_FUSED(sum, factor, x) "vfma.f32 q" #sum ", q" #factor ", " #x "\n"
#define NLO_ROUNDED(sum, factor, x)          \
  "vmul.f32 q" #factor ", q" #factor ", " #x \
  "\n"                                       \
  "vadd.f32 q" #sum ", q" #sum ", q" #factor "\n"
#define NLO_IF(at_least, text) ".if %c[size] >= " #at_least "\n" text ".endif\n"
#define NLO_TERM(op, sum, factor, x) "vldrw.u32 q" #factor ", [%[weights]], #16\n" op(sum, factor, x)
#define NLO_INPUT(op, x)           \
  NLO_TERM(op, 0, 6, x)            \
  NLO_IF(2, NLO_TERM(op, 1, 7, x)) \
  NLO_IF(3, NLO_TERM(op, 2, 6, x)) \
  NLO_IF(4, NLO_TERM(op, 3, 7, x)) NLO_IF(5, NLO_TERM(op, 4, 6, x)) NLO_IF(6, NLO_TERM(op, 5, 7, x))
// Stores `tail` values (1 to 4) of the last vector.
#define NLO_STORE(q)                                \
  ".if (%c[size] > " #q " + 1) || (%c[size] == " #q \
  " + 1 && %c[tail] == 4)\n"                        \
  "vstrw.32 q" #q ", [%[out], #16 * " #q            \
  "]\n"                                             \
  ".elseif %c[size] == " #q                         \
  " + 1\n"                                          \
  "mov r4, #%c[tail]\n"                             \
  "vctp.32 r4\n"                                    \
  "vpst\n"                                          \
  "vstrwt.32 q" #q ", [%[out], #16 * " #q           \
  "]\n"                                             \
  ".endif\n"
#define NLO_TILE(op) \
  asm volatile(                                                                                                     \
      "vldrw.u32 q0, [%[bias]]\n" NLO_IF(2, "vldrw.u32 q1, [%[bias], #16]\n")                                       \
          NLO_IF(3, "vldrw.u32 q2, [%[bias], #32]\n") NLO_IF(4, "vldrw.u32 q3, [%[bias], #48]\n")                   \
              NLO_IF(5, "vldrw.u32 q4, [%[bias], #64]\n") NLO_IF(6, "vldrw.u32 q5, [%[bias], #80]\n")               \
      ".if %c[pairs]\n"                                                                                             \
      "dls lr, %[count]\n"                                                                                          \
      "1:\n"                                                                                                        \
      "ldrd r4, r5, [%[in]], #8\n" NLO_INPUT(op, r4) NLO_INPUT(op, r5)                                              \
      "le lr, 1b\n"                                                                                                 \
      ".endif\n"                                                                                                    \
      ".if %c[odd]\n"                                                                                               \
      "ldr r4, [%[in]]\n" NLO_INPUT(op, r4)                                                                         \
      ".endif\n" NLO_STORE(0) NLO_STORE(1) NLO_STORE(2) NLO_STORE(3) NLO_STORE(4) NLO_STORE(5)                      \
      : [weights] "+r"(weights), [in] "+r"(in)                                                                      \
      : [bias] "r"(bias), [count] "r"(kIn / 2), [out] "r"(out), [size] "i"(kSize), [pairs] "i"(kIn / 2),            \
        [odd] "i"(kIn % 2), [tail] "i"(kTail)                                                                       \
      : "r4", "r5", "lr", "q0", "q1", "q2", "q3", "q4", "q5", "q6", "q7", "memory")

/// out = bias + W in for kSize vectors of outputs, the last one with kTail values. Returns a pointer to the next
/// weights.
template <int kSize, bool kFused, int kIn, int kTail>
NLO_INLINE const float* multiply_tile(const float* weights, const float* bias, const float* in, float* out) {
  static_assert(kSize >= 1 && kSize <= 6 && kTail >= 1 && kTail <= 4);
  if constexpr (kFused) {
    NLO_TILE(NLO_FUSED);
  } else {
    NLO_TILE(NLO_ROUNDED);
  }
  return weights;
}

/// Computes max(v, 0) of each value; the last round of the loop handles an incomplete vector.
template <int kN>
NLO_INLINE void relu_in_place(float* v) {
  asm volatile(
      "vmov.i32 q1, #0\n"
      "dlstp.32 lr, %[count]\n"
      "1:\n"
      "vldrw.u32 q0, [%[v]]\n"
      "vmaxnm.f32 q0, q0, q1\n"
      "vstrw.32 q0, [%[v]], #16\n"
      "letp lr, 1b\n"
      : [v] "+r"(v)
      : [count] "r"(kN)
      : "lr", "q0", "q1", "memory");
}

// One step of Horner's rule on both polynomials in x^2, which is in q1: q2 = q2 q1 + p, q3 = q3 q1 + q.
#define NLO_FUSED_STEP(p, q) \
  "vfmas.f32 q2, q1, " #p    \
  "\n"                       \
  "vfmas.f32 q3, q1, " #q "\n"
#define NLO_ROUNDED_STEP(p, q) \
  "vmul.f32 q2, q2, q1\n"      \
  "vmul.f32 q3, q3, q1\n"      \
  "vadd.f32 q2, q2, " #p       \
  "\n"                         \
  "vadd.f32 q3, q3, " #q "\n"
#define NLO_TANH(step) \
  asm volatile(                                                                                                   \
      "movw r1, #0\n"                                                                                             \
      "movt r1, #%c[limit]\n"                                                                                     \
      "vdup.32 q6, r1\n"                                                                                          \
      "vneg.f32 q7, q6\n"                                                                                         \
      "ldmia %[coefficients], {r1-r10}\n"                                                                         \
      "dlstp.32 lr, %[count]\n"                                                                                   \
      "1:\n"                                                                                                      \
      "vldrw.u32 q0, [%[at]]\n"                                                                                   \
      "vminnm.f32 q0, q0, q6\n"                                                                                   \
      "vmaxnm.f32 q0, q0, q7\n"                                                                                   \
      "vmul.f32 q1, q0, q0\n"                                                                                     \
      "vdup.32 q2, r1\n"                                                                                          \
      "vdup.32 q3, r2\n" step(r3, r7) step(r4, r8) step(r5, r9) step(r6, r10)                                     \
      "vmul.f32 q0, q0, q2\n"                                                                                     \
      "vdiv.f32 s0, s0, s12\n"                                                                                    \
      "vdiv.f32 s1, s1, s13\n"                                                                                    \
      "vdiv.f32 s2, s2, s14\n"                                                                                    \
      "vdiv.f32 s3, s3, s15\n"                                                                                    \
      "vstrw.32 q0, [%[at]], #16\n"                                                                               \
      "letp lr, 1b\n"                                                                                             \
      : [at] "+r"(at)                                                                                             \
      : [coefficients] "r"(coefficients), [count] "r"(kN), [limit] "i"(kLimit >> 16)                              \
      : "r1", "r2", "r3", "r4", "r5", "r6", "r7", "r8", "r9", "r10", "lr", "q0", "q1", "q2", "q3", "q6", "q7",    \
        "memory")

/// Computes tanh_rational() of kN values, in place: 5.3 instructions each, 7.3 unfused, for every input.
template <bool kFused, int kN>
NLO_INLINE void tanh_in_place(float* at) {
  const float* const coefficients = cortex_m::kTanhCoefficients;
  constexpr auto kLimit = std::bit_cast<std::uint32_t>(cortex_m::kBestTanh.limit);
  static_assert((kLimit & 0xffffU) == 0);
  if constexpr (kFused) {
    NLO_TANH(NLO_FUSED_STEP);
  } else {
    NLO_TANH(NLO_ROUNDED_STEP);
  }
}

/// Computes tanh_by_pieces_plain() of kN values, in place: 4 instructions each. Gathers coefficients of four rows at
/// once.
template <int kN>
NLO_INLINE void tanh_by_pieces(float* at) {
  const float* const middle = cortex_m::kTanhPieces<>.rows[cortex_m::TanhPieces::kMiddle];
  asm volatile(
      "vdup.32 q6, %[last]\n"
      "vmvn q7, q6\n"
      "dlstp.32 lr, %[count]\n"
      "1:\n"
      "vldrw.u32 q0, [%[at]]\n"
      "vcvt.s32.f32 q1, q0, #4\n"
      "vmin.s32 q1, q1, q6\n"
      "vmax.s32 q1, q1, q7\n"
      "vshl.i32 q1, q1, #4\n"
      "vldrw.u32 q2, [%[c3], q1]\n"
      "vldrw.u32 q3, [%[c2], q1]\n"
      "vldrw.u32 q4, [%[c1], q1]\n"
      "vldrw.u32 q5, [%[c0], q1]\n"
      "vfma.f32 q3, q2, q0\n"
      "vfma.f32 q4, q3, q0\n"
      "vfma.f32 q5, q4, q0\n"
      "vstrw.32 q5, [%[at]], #16\n"
      "letp lr, 1b\n"
      : [at] "+r"(at)
      : [c0] "r"(middle), [c1] "r"(middle + 1), [c2] "r"(middle + 2), [c3] "r"(middle + 3), [count] "r"(kN),
        [last] "r"(cortex_m::TanhPieces::kMiddle - 1)
      : "lr", "q0", "q1", "q2", "q3", "q4", "q5", "q6", "q7", "memory");
}

/// out = f(W in + b). `out` must not overlap `in`. Not inlined, so that layers of equal size share the code.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut>
__attribute__((noinline)) void layer(const float* weights, const float* bias, const float* in, float* out) {
  constexpr bool kFused = kArithmetic == Arithmetic::kFast && cortex_m::kFuses;
  using T = Tiles<kOut>;
  constexpr int kLarge = T::kLarge, kTail = (kOut - 1) % 4 + 1;
  constexpr int kWhole = T::kCount - 1, kWholeLarge = T::kLargeCount < kWhole ? T::kLargeCount : kWhole;
  for (int t = 0; t < kWholeLarge; ++t) {
    weights = multiply_tile<kLarge, kFused, kIn, 4>(weights, bias + 4 * kLarge * t, in, out + 4 * kLarge * t);
  }
  for (int t = kWholeLarge; t < kWhole; ++t) {
    weights = multiply_tile<T::kSmall, kFused, kIn, 4>(weights, bias + 4 * T::first(t), in, out + 4 * T::first(t));
  }
  constexpr int kLastTile = 4 * T::first(kWhole);
  multiply_tile<T::size(kWhole), kFused, kIn, kTail>(weights, bias + kLastTile, in, out + kLastTile);
  if constexpr (!kLast) {
    if constexpr (cortex_m::kByPieces<kKind, kArithmetic, kIn, kOut>) {
      tanh_by_pieces<kOut>(out);
    } else if constexpr (kKind == Activation::kTanh) {
      tanh_in_place<kFused, kOut>(out);
    } else if constexpr (kKind == Activation::kRelu) {
      relu_in_place<kOut>(out);
    } else {
      for (int o = 0; o < kOut; ++o) out[o] = cortex_m::activate_plain<kKind, kArithmetic>(out[o]);
    }
  }
}

#undef NLO_TANH
#undef NLO_ROUNDED_STEP
#undef NLO_FUSED_STEP
#undef NLO_TILE
#undef NLO_STORE
#undef NLO_INPUT
#undef NLO_TERM
#undef NLO_IF
#undef NLO_ROUNDED
#undef NLO_FUSED

}  // namespace nlo::inline NLO_ISA::kernels::cortex_m_vectors

#endif
