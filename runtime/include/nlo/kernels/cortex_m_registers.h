// SPDX-License-Identifier: MIT
// The assembly of cortex_m.h: the inner loops that compilers do not find, because they never load registers in
// multiples.
#pragma once

#include <cstdint>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/simd.h"

// Cortex-M with a single-precision FPU, optimised builds (the plain version gives the same bits).
#if defined(__ARM_ARCH_PROFILE) && defined(__ARM_FP) && !defined(NLO_SCALAR_KERNELS)
#if __ARM_ARCH_PROFILE == 'M'
#define NLO_CORTEX_M_FLOAT 1
#endif
#endif

namespace nlo::kernels::cortex_m {

/// The fit of tanh_rational(): the leading coefficients of P and Q, then the other four of each, highest power first.
inline constexpr auto& kBestTanh = kTanhFit<Activation::kTanh, float>;
inline constexpr float kTanhCoefficients[10] = {kBestTanh.p[4], kBestTanh.q[4],                                  //
                                                kBestTanh.p[3], kBestTanh.p[2], kBestTanh.p[1], kBestTanh.p[0],  //
                                                kBestTanh.q[3], kBestTanh.q[2], kBestTanh.q[1], kBestTanh.q[0]};

#if defined(NLO_CORTEX_M_FLOAT)

// One input (register x) times the weights of a block: s0.. += s13.. * x, fused or as a product and a sum.
#define NLO_FUSED(sum, weight, x) "vfma.f32 s" #sum ", s" #weight ", s" #x "\n"
#define NLO_SPLIT(sum, weight, x)             \
  "vmul.f32 s" #weight ", s" #weight ", s" #x \
  "\n"                                        \
  "vadd.f32 s" #sum ", s" #sum ", s" #weight "\n"
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

// A block of `size` outputs, sums in s0.., weights in s13.., five inputs in s26-s30: whole fives first,
// then one by one.
#define NLO_BLOCK(size, op, sums, loaded) \
  asm volatile(                                                                                                  \
      "vldmia %[bias], {" sums "}\n"                                                                         \
      "cmp %[in], %[fives]\n"                                                                                     \
      "beq 2f\n"                                                                                                 \
      "1:\n"                                                                                                     \
      "vldmia %[in]!, {s26-s30}\n"                                                                                \
      "vldmia %[weights]!, {" loaded "}\n" NLO_ROW##size(op, 26)                                            \
      "vldmia %[weights]!, {" loaded "}\n" NLO_ROW##size(op, 27)                                            \
      "vldmia %[weights]!, {" loaded "}\n" NLO_ROW##size(op, 28)                                            \
      "vldmia %[weights]!, {" loaded "}\n" NLO_ROW##size(op, 29)                                            \
      "vldmia %[weights]!, {" loaded "}\n" NLO_ROW##size(op, 30)                                            \
      "cmp %[in], %[fives]\n"                                                                                     \
      "bne 1b\n"                                                                                                 \
      "2:\n"                                                                                                     \
      "cmp %[in], %[end]\n"                                                                                       \
      "beq 4f\n"                                                                                                 \
      "3:\n"                                                                                                     \
      "vldmia %[in]!, {s26}\n"                                                                                    \
      "vldmia %[weights]!, {" loaded "}\n" NLO_ROW##size(op, 26)                                            \
      "cmp %[in], %[end]\n"                                                                                       \
      "bne 3b\n"                                                                                                 \
      "4:\n"                                                                                                     \
      "vstmia %[out], {" sums "}\n"                                                                          \
      : [weights] "+r"(weights), [in] "+r"(in)                                                                   \
      : [bias] "r"(bias), [fives] "r"(fives), [end] "r"(end), [out] "r"(out)                                     \
      : "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9", "s10", "s11", "s12", "s13", "s14", "s15",    \
        "s16", "s17", "s18", "s19", "s20", "s21", "s22", "s23", "s24", "s25", "s26", "s27", "s28", "s29", "s30", \
        "cc", "memory")
#define NLO_BLOCK_OF(size, sums, loaded)        \
  if constexpr (kSize == size) {                \
    if constexpr (kFused) {                     \
      NLO_BLOCK(size, NLO_FUSED, sums, loaded); \
    } else {                                    \
      NLO_BLOCK(size, NLO_SPLIT, sums, loaded); \
    }                                           \
  }

/// out = bias + W in for kSize outputs; returns the weights behind theirs.
template <int kSize, bool kFused, int kIn>
NLO_INLINE const float* multiply_block(const float* weights, const float* bias, const float* in, float* out) {
  static_assert(kSize >= 1 && kSize <= 13);
  const float* fives = in + kIn / 5 * 5;
  const float* end = in + kIn;
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
  return weights;
}

// One step of Horner's rule on each of two polynomials, next coefficients in s`p` and s`q`, in s14 = x^2. They come
// fresh from memory each time, eight in one instruction, as the sums overwrite them.
#define NLO_FUSED_STEP(from_p, p, from_q, q) \
  "vfma.f32 s" #p ", s" #from_p              \
  ", s14\n"                                  \
  "vfma.f32 s" #q ", s" #from_q ", s14\n"
#define NLO_SPLIT_STEP(from_p, p, from_q, q) \
  "vmul.f32 s8, s" #from_p                   \
  ", s14\n"                                  \
  "vmul.f32 s9, s" #from_q                   \
  ", s14\n"                                  \
  "vadd.f32 s" #p ", s" #p                   \
  ", s8\n"                                   \
  "vadd.f32 s" #q ", s" #q ", s9\n"
// Past the limit tanh is that of the limit: the sign falls out of the comparison, |x| > limit, or not a number. Fast: a
// branch that is hardly ever taken. Deterministic: one instruction more, and as many of them whatever x is.
#define NLO_CLAMP_RARELY            \
  "vldmia %[at], {s13}\n"           \
  "vmov %[bits], s13\n"             \
  "cmp %[limit], %[bits], lsl #1\n" \
  "blo 3f\n"                        \
  "2:\n"
#define NLO_RARELY                           \
  "3:\n"                                     \
  "and %[bits], %[bits], #0x80000000\n"      \
  "orr %[bits], %[bits], %[limit], lsr #1\n" \
  "vmov s13, %[bits]\n"                      \
  "b 2b\n"
#define NLO_CLAMP_ALWAYS                 \
  "ldr %[bits], [%[at]]\n"               \
  "cmp %[limit], %[bits], lsl #1\n"      \
  "it lo\n"                              \
  "bfilo %[bits], %[clamped], #0, #31\n" \
  "vmov s13, %[bits]\n"
#define NLO_TANH(step, clamp, rarely) \
  asm volatile(                                                                                                 \
      "vldmia %[coefficients]!, {s10-s11}\n"                                                                           \
      "1:\n"                                                                                                    \
      "vldmia %[coefficients], {s0-s7}\n"                                                                                \
      clamp                                                                                                     \
      "vmul.f32 s14, s13, s13\n"                                                                                \
      step(10, 0, 11, 4) step(0, 1, 4, 5) step(1, 2, 5, 6) step(2, 3, 6, 7)                                     \
      "vmul.f32 s13, s13, s3\n"                                                                                 \
      "vdiv.f32 s13, s13, s7\n"                                                                                 \
      "vstmia %[at]!, {s13}\n"                                                                                   \
      "cmp %[at], %[end]\n"                                                                                      \
      "bne 1b\n"                                                                                                \
      "b 4f\n"                                                                                                  \
      rarely                                                                                                    \
      "4:\n"                                                                                                    \
      : [at] "+r"(at), [coefficients] "+r"(coefficients), [bits] "=&r"(bits)                                                                       \
      : [end] "r"(end), [limit] "r"(kLimit << 1), [clamped] "r"(kLimit)        \
      : "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9", "s10", "s11", "s13", "s14", "cc", "memory")

/// tanh_rational() of each value from `at` to `end`, at least one. 19 instructions each (28 unfused).
template <bool kFused>
NLO_INLINE void tanh_in_place(float* at, const float* end) {
  const float* coefficients = kTanhCoefficients;
  constexpr std::uint32_t kLimit = 0x40f80000U;
  std::uint32_t bits;
  if constexpr (kFused) {
    NLO_TANH(NLO_FUSED_STEP, NLO_CLAMP_RARELY, NLO_RARELY);
  } else {
    NLO_TANH(NLO_SPLIT_STEP, NLO_CLAMP_ALWAYS, "");
  }
}

#undef NLO_TANH
#undef NLO_CLAMP_ALWAYS
#undef NLO_RARELY
#undef NLO_CLAMP_RARELY
#undef NLO_SPLIT_STEP
#undef NLO_FUSED_STEP
#undef NLO_BLOCK_OF
#undef NLO_BLOCK
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
#undef NLO_SPLIT
#undef NLO_FUSED

#endif  // NLO_CORTEX_M_FLOAT

}  // namespace nlo::kernels::cortex_m
