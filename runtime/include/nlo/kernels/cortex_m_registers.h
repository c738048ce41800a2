// SPDX-License-Identifier: MIT
// The inner loops of cortex_m.h in assembly, because compilers do not use multiple-register loads there.
#pragma once

#include <bit>
#include <cstdint>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/simd.h"

// Only for a Cortex-M with a single-precision FPU in optimised builds. Elsewhere the plain version gives the same bits.
#if defined(__ARM_ARCH_PROFILE) && defined(__ARM_FP) && !defined(NLO_SCALAR_KERNELS)
#if __ARM_ARCH_PROFILE == 'M'
#define NLO_CORTEX_M_FLOAT 1
#endif
#endif

namespace nlo::inline NLO_ISA::kernels::cortex_m {

/// Coefficients of tanh_rational(): the leading coefficients of P and Q, then the other four of each, highest power
/// first. These eight are stored twice, once for each value of a pair.
inline constexpr auto& kBestTanh = kTanhFit<Activation::kTanh, float>;
inline constexpr float kTanhCoefficients[18] = {
    kBestTanh.p[4], kBestTanh.q[4],                                                                                  //
    kBestTanh.p[3], kBestTanh.p[2], kBestTanh.p[1], kBestTanh.p[0], kBestTanh.q[3], kBestTanh.q[2], kBestTanh.q[1],  //
    kBestTanh.q[0],                                                                                                  //
    kBestTanh.p[3], kBestTanh.p[2], kBestTanh.p[1], kBestTanh.p[0], kBestTanh.q[3], kBestTanh.q[2], kBestTanh.q[1],  //
    kBestTanh.q[0]};

#if defined(NLO_CORTEX_M_FLOAT)

// sum += factor * x: fused, or rounded twice in one instruction, or as a product in s31 and a sum.
#define NLO_FUSED(sum, factor, x) "vfma.f32 s" #sum ", s" #factor ", s" #x "\n"
#if defined(NLO_CORTEX_M_NO_FMA)
#define NLO_ROUNDED(sum, factor, x)  \
  "vmul.f32 s31, s" #factor ", s" #x \
  "\n"                               \
  "vadd.f32 s" #sum ", s" #sum ", s31\n"
#else
#define NLO_ROUNDED(sum, factor, x) "vmla.f32 s" #sum ", s" #factor ", s" #x "\n"
#endif
// Adds one input (register x) times the weights of a block: s0.. += s13.. * x.
#define NLO_ROW1(op, x) op(0, 13, x)
#define NLO_ROW2(op, x) NLO_ROW1(op, x) op(1, 14, x)
#define NLO_ROW3(op, x) NLO_ROW2(op, x) op(2, 15, x)
#define NLO_ROW4(op, x) NLO_ROW3(op, x) op(3, 16, x)
#define NLO_ROW5(op, x) NLO_ROW4(op, x) op(4, 17, x)
#define NLO_ROW6(op, x) NLO_ROW5(op, x) op(5, 18, x)
#define NLO_ROW7(op, x) NLO_ROW6(op, x) op(6, 19, x)
#define NLO_ROW8(op, x) NLO_ROW7(op, x) op(7, 20, x)
#define NLO_ROW9(op, x) NLO_ROW8(op, x) op(8, 21, x)
#define NLO_ROW10(op, x) NLO_ROW9(op, x) op(9, 22, x)
#define NLO_ROW11(op, x) NLO_ROW10(op, x) op(10, 23, x)
#define NLO_ROW12(op, x) NLO_ROW11(op, x) op(11, 24, x)
#define NLO_ROW13(op, x) NLO_ROW12(op, x) op(12, 25, x)

// A block of `size` outputs: sums in s0.., weights in s13.., up to five inputs in s26... It processes `tens` times ten
// inputs, then five if at least five are left, then the `rest`. Parts without inputs are not assembled.
#define NLO_INPUT(size, op, loaded, x) "vldmia %[weights]!, {" loaded "}\n" NLO_ROW##size(op, x)
#define NLO_FIVE(size, op, loaded)                                                             \
  "vldmia %[in]!, {s26-s30}\n" NLO_INPUT(size, op, loaded, 26) NLO_INPUT(size, op, loaded, 27) \
      NLO_INPUT(size, op, loaded, 28) NLO_INPUT(size, op, loaded, 29) NLO_INPUT(size, op, loaded, 30)
#define NLO_INPUT_IF(at_least, size, op, loaded, x) \
  ".if %c[rest] >= " #at_least "\n" NLO_INPUT(size, op, loaded, x) ".endif\n"
#define NLO_BLOCK(size, op, sums, loaded) \
  asm volatile(                                                                                                  \
      "vldmia %[bias]!, {" sums "}\n"                                                                            \
      ".if %c[tens]\n"                                                                                           \
      "1:\n" NLO_FIVE(size, op, loaded) NLO_FIVE(size, op, loaded)                                               \
      ".if %c[tens] > 1\n"                                                                                       \
      "cmp %[in], %[tens_end]\n"                                                                                 \
      "bne 1b\n"                                                                                                 \
      ".endif\n"                                                                                                 \
      ".endif\n"                                                                                                 \
      ".if %c[five]\n" NLO_FIVE(size, op, loaded) ".endif\n"                                                    \
      ".if %c[rest] == 1\n vldmia %[in]!, {s26}\n .endif\n"                                                      \
      ".if %c[rest] == 2\n vldmia %[in]!, {s26-s27}\n .endif\n"                                                  \
      ".if %c[rest] == 3\n vldmia %[in]!, {s26-s28}\n .endif\n"                                                  \
      ".if %c[rest] == 4\n vldmia %[in]!, {s26-s29}\n .endif\n"                                                  \
      NLO_INPUT_IF(1, size, op, loaded, 26) NLO_INPUT_IF(2, size, op, loaded, 27)                                \
      NLO_INPUT_IF(3, size, op, loaded, 28) NLO_INPUT_IF(4, size, op, loaded, 29)                                \
      "vstmia %[out]!, {" sums "}\n"                                                                             \
      : [weights] "+r"(weights), [bias] "+r"(bias), [in] "+r"(in), [out] "+r"(out)                               \
      : [tens_end] "r"(tens_end), [tens] "i"(kIn / 10), [five] "i"(kIn % 10 / 5), [rest] "i"(kIn % 5)            \
      : "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9", "s10", "s11", "s12", "s13", "s14", "s15",    \
        "s16", "s17", "s18", "s19", "s20", "s21", "s22", "s23", "s24", "s25", "s26", "s27", "s28", "s29", "s30", \
        "s31", "cc", "memory")
#define NLO_BLOCK_OF(size, sums, loaded)          \
  if constexpr (kSize == size) {                  \
    if constexpr (kFused) {                       \
      NLO_BLOCK(size, NLO_FUSED, sums, loaded);   \
    } else {                                      \
      NLO_BLOCK(size, NLO_ROUNDED, sums, loaded); \
    }                                             \
  }

/// out = bias + W in for kSize outputs. Advances the pointers to weights, biases and outputs to the next block.
template <int kSize, bool kFused, int kIn>
NLO_INLINE void multiply_block(const float*& weights, const float*& bias, const float* in, float*& out) {
  static_assert(kSize >= 1 && kSize <= 13);
  const float* tens_end = in + kIn / 10 * 10;
  NLO_BLOCK_OF(1, "s0", "s13")
  NLO_BLOCK_OF(2, "s0-s1", "s13-s14")
  NLO_BLOCK_OF(3, "s0-s2", "s13-s15")
  NLO_BLOCK_OF(4, "s0-s3", "s13-s16")
  NLO_BLOCK_OF(5, "s0-s4", "s13-s17")
  NLO_BLOCK_OF(6, "s0-s5", "s13-s18")
  NLO_BLOCK_OF(7, "s0-s6", "s13-s19")
  NLO_BLOCK_OF(8, "s0-s7", "s13-s20")
  NLO_BLOCK_OF(9, "s0-s8", "s13-s21")
  NLO_BLOCK_OF(10, "s0-s9", "s13-s22")
  NLO_BLOCK_OF(11, "s0-s10", "s13-s23")
  NLO_BLOCK_OF(12, "s0-s11", "s13-s24")
  NLO_BLOCK_OF(13, "s0-s12", "s13-s25")
}

/// Computes max(v, 0) of each value by its bits, ten values at a time: 1.6 instructions each. A comparison of floats
/// takes five.
template <int kN>
NLO_INLINE void relu_in_place(float* v) {
#define NLO_POSITIVE(r) "bic " #r ", " #r ", " #r ", asr #31\n"
#define NLO_FIVE_POSITIVE                                                                     \
  "ldmia %[v], {r2-r6}\n" NLO_POSITIVE(r2) NLO_POSITIVE(r3) NLO_POSITIVE(r4) NLO_POSITIVE(r5) \
      NLO_POSITIVE(r6) "stmia %[v]!, {r2-r6}\n"
  for (int i = 0; i < kN / 10; ++i)
    asm volatile(NLO_FIVE_POSITIVE NLO_FIVE_POSITIVE : [v] "+r"(v) : : "r2", "r3", "r4", "r5", "r6", "memory");
#undef NLO_FIVE_POSITIVE
#undef NLO_POSITIVE
  typedef std::int32_t Bits __attribute__((may_alias));
  Bits* bits = reinterpret_cast<Bits*>(v);
#pragma GCC unroll 10
  for (int i = 0; i < kN % 10; ++i) bits[i] &= ~(bits[i] >> 31);
}

// tanh of a pair of values in s`x` and s`y`, with their squares in s`xx` and s`yy`, by Horner's rule on four
// polynomials. One instruction loads sixteen coefficients each time, because the sums overwrite them. The leading ones
// are in s26, s27.
#define NLO_TANH_PAIR(op, x, xx, y, yy)                                                                            \
  "vldmia %[coefficients], {s0-s15}\n" op(0, 26, xx) op(4, 27, xx) op(8, 26, yy) op(12, 27, yy) op(1, 0, xx)       \
      op(5, 4, xx) op(9, 8, yy) op(13, 12, yy) op(2, 1, xx) op(6, 5, xx) op(10, 9, yy) op(14, 13, yy) op(3, 2, xx) \
          op(7, 6, xx) op(11, 10, yy) op(15, 14, yy) "vmul.f32 s" #x ", s" #x                                      \
                                                     ", s3\n"                                                      \
                                                     "vmul.f32 s" #y ", s" #y                                      \
                                                     ", s11\n"                                                     \
                                                     "vdiv.f32 s" #x ", s" #x                                      \
                                                     ", s7\n"                                                      \
                                                     "vdiv.f32 s" #y ", s" #y ", s15\n"
#define NLO_TANH_ONE(op) \
  "vmul.f32 s16, s20, s20\n"                      \
  "vldmia %[coefficients], {s0-s7}\n"             \
  op(0, 26, 16) op(4, 27, 16) op(1, 0, 16) op(5, 4, 16) op(2, 1, 16) op(6, 5, 16) op(3, 2, 16) op(7, 6, 16) \
  "vmul.f32 s20, s20, s3\n"                       \
  "vdiv.f32 s20, s20, s7\n"
#define NLO_SQUARES          \
  "vmul.f32 s16, s20, s20\n" \
  "vmul.f32 s17, s21, s21\n" \
  "vmul.f32 s18, s22, s22\n" \
  "vmul.f32 s19, s23, s23\n"
// Clamps x to +-limit. The comparison |x| > limit also gives the sign; it is true for NaN.
#define NLO_CLAMP(bits) \
  "cmp %[limit], " bits \
  ", lsl #1\n"          \
  "it lo\n"             \
  "bfilo " bits ", %[clamped], #0, #31\n"
// Fast policy: one branch for four values, taken if the sum of their squares exceeds the square of the limit.
#define NLO_FOUR_RARELY                   \
  "vldmia %[at], {s20-s23}\n" NLO_SQUARES \
  "vadd.f32 s24, s16, s17\n"              \
  "vadd.f32 s25, s18, s19\n"              \
  "vadd.f32 s24, s24, s25\n"              \
  "vmov %[bits], s24\n"                   \
  "cmp %[bits], %[spare]\n"               \
  "bgt 3f\n"                              \
  "2:\n"
#define NLO_CLAMPED(x) "vmov %[bits], s" #x "\n" NLO_CLAMP("%[bits]") "vmov s" #x ", %[bits]\n"
#define NLO_RARELY                                                                   \
  "b 5f\n"                                                                           \
  "3:\n" NLO_CLAMPED(20) NLO_CLAMPED(21) NLO_CLAMPED(22) NLO_CLAMPED(23) NLO_SQUARES \
      "b 2b\n"                                                                       \
      "5:\n"
// Deterministic policy: the same number of instructions for every x.
#define NLO_TWO_CLAMPED(x, y, at)                                                                               \
  "ldrd %[bits], %[spare], [%[at], #" #at "]\n" NLO_CLAMP("%[bits]") NLO_CLAMP("%[spare]") "vmov s" #x ", s" #y \
                                                                                           ", %[bits], %[spare]\n"
#define NLO_FOUR_ALWAYS NLO_TWO_CLAMPED(20, 21, 0) NLO_TWO_CLAMPED(22, 23, 8) NLO_SQUARES
#define NLO_TANH(op, four, rarely) \
  asm volatile(                                                                                                    \
      "vldmia %[coefficients]!, {s26-s27}\n"                                                                       \
      ".if %c[fours]\n"                                                                                            \
      "1:\n" four NLO_TANH_PAIR(op, 20, 16, 21, 17) NLO_TANH_PAIR(op, 22, 18, 23, 19)                              \
      "vstmia %[at]!, {s20-s23}\n"                                                                                 \
      "cmp %[at], %[fours_end]\n"                                                                                  \
      "bne 1b\n" rarely                                                                                            \
      ".endif\n"                                                                                                   \
      ".rept %c[rest]\n"                                                                                           \
      "ldr %[bits], [%[at]]\n" NLO_CLAMP("%[bits]")                                                                \
      "vmov s20, %[bits]\n" NLO_TANH_ONE(op)                                                                       \
      "vstmia %[at]!, {s20}\n"                                                                                     \
      ".endr\n"                                                                                                    \
      : [at] "+r"(at), [coefficients] "+r"(coefficients), [bits] "=&r"(bits), [spare] "+r"(spare)                  \
      : [fours_end] "r"(fours_end), [limit] "r"(kLimit << 1), [clamped] "r"(kLimit), [fours] "i"(kN / 4),          \
        [rest] "i"(kN % 4)                                                                                         \
      : "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9", "s10", "s11", "s12",   \
        "s13", "s14", "s15", "s16", "s17", "s18", "s19", "s20", "s21", "s22", "s23", "s24", "s25", "s26", "s27",   \
        "s31", "cc", "memory")

/// Computes tanh_rational() of kN values, in place: 14.5 instructions each, 15.75 in the deterministic policy.
template <bool kFused, int kN>
NLO_INLINE void tanh_in_place(float* at) {
  const float* coefficients = kTanhCoefficients;
  const float* const fours_end = at + kN / 4 * 4;
  constexpr auto kLimit = std::bit_cast<std::uint32_t>(kBestTanh.limit);
  std::uint32_t bits, spare = std::bit_cast<std::uint32_t>(kBestTanh.limit * kBestTanh.limit);
  if constexpr (kFused) {
    NLO_TANH(NLO_FUSED, NLO_FOUR_RARELY, NLO_RARELY);
  } else {
    NLO_TANH(NLO_ROUNDED, NLO_FOUR_ALWAYS, "");
  }
}

#undef NLO_TANH
#undef NLO_FOUR_ALWAYS
#undef NLO_TWO_CLAMPED
#undef NLO_RARELY
#undef NLO_CLAMPED
#undef NLO_FOUR_RARELY
#undef NLO_CLAMP
#undef NLO_SQUARES
#undef NLO_TANH_ONE
#undef NLO_TANH_PAIR
#undef NLO_BLOCK_OF
#undef NLO_BLOCK
#undef NLO_INPUT_IF
#undef NLO_FIVE
#undef NLO_INPUT
#undef NLO_ROW13
#undef NLO_ROW12
#undef NLO_ROW11
#undef NLO_ROW10
#undef NLO_ROW9
#undef NLO_ROW8
#undef NLO_ROW7
#undef NLO_ROW6
#undef NLO_ROW5
#undef NLO_ROW4
#undef NLO_ROW3
#undef NLO_ROW2
#undef NLO_ROW1
#undef NLO_ROUNDED
#undef NLO_FUSED

#endif  // NLO_CORTEX_M_FLOAT

}  // namespace nlo::inline NLO_ISA::kernels::cortex_m
