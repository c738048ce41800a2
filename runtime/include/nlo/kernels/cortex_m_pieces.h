// SPDX-License-Identifier: MIT
// tanh in float32 by 256 cubic polynomials, for large layers on Cortex-M cores with an FPU, in the fast policy. The
// four coefficients of a cubic are one multiple-register load, and there is no division. A value takes 8 instructions,
// where tanh_rational() takes 14 and a VDIV of 14 cycles. The error is below 2.3e-7, half of that of tanh_rational().
// The table takes 4 KB of flash.
#pragma once

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/cortex_m_registers.h"
#include "nlo/kernels/simd.h"

namespace nlo::inline NLO_ISA::kernels::cortex_m {

/// Row 128 + k: coefficients of c_0 + c_1 x + c_2 x^2 + c_3 x^3 for all x with trunc(16 x) = k. The first and the
/// last row also apply to all x beyond the table.
struct TanhPieces {
  static constexpr int kEach = 16, kRows = 256, kMiddle = kRows / 2;
  alignas(16) float rows[kRows][4];
};

/// Interpolates tanh at four Chebyshev nodes of each piece; the piece around 0 is x - 0.33288 x^3. The function is odd.
/// A template, so that only programs that use the table compute it.
template <class Scalar = double>
inline constexpr TanhPieces kTanhPieces = [] {
  constexpr int kMiddle = TanhPieces::kMiddle;
  constexpr Scalar kNodes[4] = {Scalar(-0.92387953251128674), Scalar(-0.38268343236508977), Scalar(0.38268343236508977),
                                Scalar(0.92387953251128674)};
  TanhPieces pieces{};
  for (int k = 0; k <= kMiddle; ++k) {
    Scalar c[4] = {Scalar(1.0F - 0x1p-22F), 0, 0, 0};
    if (k == 0) {
      c[0] = 0;
      c[1] = 1;
      c[3] = Scalar(-0.33288);
    } else if (k < kMiddle - 1) {
      constexpr Scalar kHalf = Scalar(0.5) / TanhPieces::kEach;
      Scalar x[4]{}, d[4]{};  // nodes and divided differences
      for (int i = 0; i < 4; ++i) {
        x[i] = (static_cast<Scalar>(2 * k + 1) + kNodes[i]) * kHalf;
        d[i] = tanh_rational<Activation::kTanh, Arithmetic::kDeterministic>(x[i]);
      }
      for (int order = 1; order < 4; ++order) {
        for (int i = 3; i >= order; --i) d[i] = (d[i] - d[i - 1]) / (x[i] - x[i - order]);
      }
      c[0] = d[3];  // expands Newton's form from its last term
      for (int i = 2; i >= 0; --i) {
        for (int j = 3; j > 0; --j) c[j] = c[j - 1] - x[i] * c[j];
        c[0] = d[i] - x[i] * c[0];
      }
    }
    for (int j = 0; j < 4; ++j) {
      const auto rounded_once = static_cast<float>(c[j]);
      if (k < kMiddle) pieces.rows[kMiddle + k][j] = rounded_once;
      if (k > 0) pieces.rows[kMiddle - k][j] = j % 2 == 0 ? -rounded_once : rounded_once;
    }
  }
  return pieces;
}();

/// True if a layer uses the table: the table must not be larger than its weights.
template <int kIn, int kOut>
inline constexpr bool kTakesPieces = kIn* kOut >= 4 * TanhPieces::kRows;

/// Computes the same as the assembly for finite x. An infinite x gives NaN; only a sum that overflows is infinite.
inline float tanh_by_pieces_plain(float x) {
  constexpr float kEnd = static_cast<float>(TanhPieces::kMiddle) / TanhPieces::kEach;
  int k = TanhPieces::kMiddle - 1;
  if (x <= -kEnd) {
    k = -TanhPieces::kMiddle;
  } else if (x < kEnd) {
    k = static_cast<int>(x * static_cast<float>(TanhPieces::kEach));
  }
  const float(&c)[4] = kTanhPieces<>.rows[TanhPieces::kMiddle + k];
  return __builtin_fmaf(__builtin_fmaf(__builtin_fmaf(c[3], x, c[2]), x, c[1]), x, c[0]);
}

#if defined(NLO_CORTEX_M_FLOAT)

// Loads the rows at r and t into a0-a3 and b0-b3 and evaluates their cubics at x and y; the results are in a0 and b0.
#define NLO_TERM(sum, factor, x) "vfma.f32 s" #sum ", s" #factor ", s" #x "\n"
#define NLO_TWO_CUBICS(r, a0, a1, a2, a3, x, t, b0, b1, b2, b3, y)                                   \
  "vldmia " #r ", {s" #a0 "-s" #a3                                                                   \
  "}\n"                                                                                              \
  "vldmia " #t ", {s" #b0 "-s" #b3 "}\n" NLO_TERM(a2, a3, x) NLO_TERM(b2, b3, y) NLO_TERM(a1, a2, x) \
      NLO_TERM(b1, b2, y) NLO_TERM(a0, a1, x) NLO_TERM(b0, b1, y)
#define NLO_FIXED(x) "vcvt.s32.f32 s" #x ", s" #x ", #4\n"
#define NLO_ROW(r)       \
  "ssat " #r ", #8, " #r \
  "\n"                   \
  "add " #r ", %[middle], " #r ", lsl #4\n"

/// Computes tanh_by_pieces_plain() of kN values, in place.
template <int kN>
NLO_INLINE void tanh_by_pieces(float* at) {
  asm volatile(
      ".if %c[eights]\n"
      "1:\n"
      "vldmia %[at], {s16-s23}\n"
      "vldmia %[at], {s24-s31}\n" NLO_FIXED(24) NLO_FIXED(25) NLO_FIXED(26) NLO_FIXED(27) NLO_FIXED(28) NLO_FIXED(29)
          NLO_FIXED(30) NLO_FIXED(31)
      "vstmia %[at], {s24-s31}\n"
      "ldmia %[at], {r2-r6, r8, r12, lr}\n" NLO_ROW(r2) NLO_ROW(r3) NLO_ROW(r4) NLO_ROW(r5) NLO_ROW(r6) NLO_ROW(r8)
          NLO_ROW(r12) NLO_ROW(lr) NLO_TWO_CUBICS(r2, 0, 1, 2, 3, 16, r6, 8, 9, 10, 11, 20)
              NLO_TWO_CUBICS(r3, 1, 2, 3, 4, 17, r8, 9, 10, 11, 12, 21)
                  NLO_TWO_CUBICS(r4, 2, 3, 4, 5, 18, r12, 10, 11, 12, 13, 22)
                      NLO_TWO_CUBICS(r5, 3, 4, 5, 6, 19, lr, 11, 12, 13, 14, 23)
      "vstmia %[at]!, {s0-s3}\n"
      "vstmia %[at]!, {s8-s11}\n"
      "cmp %[at], %[end]\n"
      "bne 1b\n"
      ".endif\n"
      ".rept %c[rest]\n"
      "vldr s16, [%[at]]\n"
      "vldr s24, [%[at]]\n" NLO_FIXED(24)
      "vmov r2, s24\n" NLO_ROW(r2)
      "vldmia r2, {s0-s3}\n" NLO_TERM(2, 3, 16) NLO_TERM(1, 2, 16) NLO_TERM(0, 1, 16)
      "vstmia %[at]!, {s0}\n"
      ".endr\n"
      : [at] "+r"(at)
      : [middle] "r"(kTanhPieces<>.rows[TanhPieces::kMiddle]), [end] "r"(at + kN / 8 * 8), [eights] "i"(kN / 8),
        [rest] "i"(kN % 8)
      : "r2", "r3", "r4", "r5", "r6", "r8", "r12", "lr", "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s8", "s9", "s10",
        "s11", "s12", "s13", "s14", "s16", "s17", "s18", "s19", "s20", "s21", "s22", "s23", "s24", "s25", "s26", "s27",
        "s28", "s29", "s30", "s31", "cc", "memory");
}

#undef NLO_ROW
#undef NLO_FIXED
#undef NLO_TWO_CUBICS
#undef NLO_TERM

#endif

}  // namespace nlo::inline NLO_ISA::kernels::cortex_m
