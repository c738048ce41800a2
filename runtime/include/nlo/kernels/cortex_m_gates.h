// SPDX-License-Identifier: MIT
// The element-wise part of a step of gated units (gated.inc) for Cortex-M cores with an FPU. Eight units at a time are
// loaded and stored by multiple-register instructions. reset_units() takes 2.6 instructions per unit and move_units()
// 3.9; compiled loops take 8 and 10. The functions ..._plain() give the same bits in C++ on any machine.
#pragma once

#include <bit>
#include <cstdint>

#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/cortex_m.h"

namespace nlo::inline NLO_ISA::kernels::cortex_m {

template <Arithmetic kArithmetic>
float gate_plain(float t) {
  return kernel_multiply_add<kArithmetic>(t, 0.5F, 0.5F);
}

/// in = gate_of(t) z, for kN units.
template <Arithmetic kArithmetic, int kN>
void reset_units_plain(const float* t, const float* z, float* in) {
  for (int i = 0; i < kN; ++i) in[i] = z[i] * gate_plain<kArithmetic>(t[i]);
}

/// z += gate_of(t) (target - z), for kN units.
template <Arithmetic kArithmetic, int kN>
void move_units_plain(const float* t, const float* target, float* z) {
  for (int i = 0; i < kN; ++i) {
    z[i] = kernel_multiply_add<kArithmetic>(gate_plain<kArithmetic>(t[i]), target[i] - z[i], z[i]);
  }
}

// On cores with vectors of floats, compiled loops use these vectors.
#if defined(NLO_CORTEX_M_FLOAT) && !defined(__ARM_FEATURE_MVE)
#define NLO_CORTEX_M_GATES 1

/// to = from. Returns true if all values are finite and below 2 in magnitude, by the upper bit of their exponents.
template <int kN>
__attribute__((noinline)) bool copy_below_2(const float* from, float* to) {
  std::uint32_t together = 0, bits;
#define NLO_TOGETHER(r) "orr %[together], " #r "\n"
  asm volatile(
      ".if %c[eights]\n"
      "1:\n"
      "ldmia %[from]!, {r2-r6, r8, r10, r12}\n" NLO_TOGETHER(r2) NLO_TOGETHER(r3) NLO_TOGETHER(r4) NLO_TOGETHER(r5)
          NLO_TOGETHER(r6) NLO_TOGETHER(r8) NLO_TOGETHER(r10) NLO_TOGETHER(r12)
      "stmia %[to]!, {r2-r6, r8, r10, r12}\n"
      "cmp %[to], %[end]\n"
      "bne 1b\n"
      ".endif\n"
      ".rept %c[rest]\n"
      "ldr %[bits], [%[from]], #4\n" NLO_TOGETHER(%[bits])
      "str %[bits], [%[to]], #4\n"
      ".endr\n"
      : [from] "+r"(from), [to] "+r"(to), [together] "+r"(together), [bits] "=&r"(bits)
      : [end] "r"(to + kN / 8 * 8), [eights] "i"(kN / 8), [rest] "i"(kN % 8)
      : "r2", "r3", "r4", "r5", "r6", "r8", "r10", "r12", "cc", "memory");
#undef NLO_TOGETHER
  return (together & std::bit_cast<std::uint32_t>(2.0F)) == 0;
}

inline constexpr float kHalves[8] = {0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0.5F};

// sum += factor * x. The register of `factor` may be overwritten.
#define NLO_FUSED(sum, factor, x) "vfma.f32 s" #sum ", s" #factor ", s" #x "\n"
#if defined(NLO_CORTEX_M_NO_FMA)
#define NLO_ROUNDED(sum, factor, x)           \
  "vmul.f32 s" #factor ", s" #factor ", s" #x \
  "\n"                                        \
  "vadd.f32 s" #sum ", s" #sum ", s" #factor "\n"
#else
#define NLO_ROUNDED(sum, factor, x) "vmla.f32 s" #sum ", s" #factor ", s" #x "\n"
#endif
// For one unit: replaces `gate`, which holds tanh t, by gate_of(t). Then replaces z by z gate, or by z + gate (target -
// z).
#define NLO_RESET(op, t, z, gate) op(gate, t, gate) "vmul.f32 s" #z ", s" #z ", s" #gate "\n"
#define NLO_MOVE(op, t, target, z, gate) \
  op(gate, t, gate) "vsub.f32 s" #target ", s" #target ", s" #z "\n" op(z, target, gate)

#define NLO_RESETS(op) \
  asm volatile(                                                                                                    \
      ".if %c[eights]\n"                                                                                           \
      "1:\n"                                                                                                       \
      "vldmia %[t]!, {s0-s7}\n"                                                                                    \
      "vldmia %[z]!, {s8-s15}\n"                                                                                   \
      "vldmia %[halves], {s16-s23}\n" NLO_RESET(op, 0, 8, 16) NLO_RESET(op, 1, 9, 17) NLO_RESET(op, 2, 10, 18)     \
          NLO_RESET(op, 3, 11, 19) NLO_RESET(op, 4, 12, 20) NLO_RESET(op, 5, 13, 21) NLO_RESET(op, 6, 14, 22)      \
              NLO_RESET(op, 7, 15, 23)                                                                             \
      "vstmia %[in]!, {s8-s15}\n"                                                                                  \
      "cmp %[in], %[end]\n"                                                                                        \
      "bne 1b\n"                                                                                                   \
      ".endif\n"                                                                                                   \
      ".rept %c[rest]\n"                                                                                           \
      "vldmia %[t]!, {s0}\n"                                                                                       \
      "vldmia %[z]!, {s8}\n"                                                                                       \
      "vldr s16, [%[halves]]\n" NLO_RESET(op, 0, 8, 16)                                                            \
      "vstmia %[in]!, {s8}\n"                                                                                      \
      ".endr\n"                                                                                                    \
      : [t] "+r"(t), [z] "+r"(z), [in] "+r"(in)                                                                    \
      : [halves] "r"(kHalves), [end] "r"(in + kN / 8 * 8), [eights] "i"(kN / 8), [rest] "i"(kN % 8)                \
      : "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9", "s10", "s11", "s12", "s13", "s14", "s15",      \
        "s16", "s17", "s18", "s19", "s20", "s21", "s22", "s23", "cc", "memory")

/// Computes reset_units_plain(). Not inlined, so that its saved registers use the same stack as those of a layer.
template <bool kFused, int kN>
__attribute__((noinline)) void reset_units(const float* t, const float* z, float* in) {
  if constexpr (kFused) {
    NLO_RESETS(NLO_FUSED);
  } else {
    NLO_RESETS(NLO_ROUNDED);
  }
}

#define NLO_MOVES(op) \
  asm volatile(                                                                                                    \
      ".if %c[eights]\n"                                                                                           \
      "1:\n"                                                                                                       \
      "vldmia %[t]!, {s0-s7}\n"                                                                                    \
      "vldmia %[target]!, {s8-s15}\n"                                                                              \
      "vldmia %[z], {s16-s23}\n"                                                                                   \
      "vldmia %[halves], {s24-s31}\n" NLO_MOVE(op, 0, 8, 16, 24) NLO_MOVE(op, 1, 9, 17, 25)                        \
          NLO_MOVE(op, 2, 10, 18, 26) NLO_MOVE(op, 3, 11, 19, 27) NLO_MOVE(op, 4, 12, 20, 28)                      \
              NLO_MOVE(op, 5, 13, 21, 29) NLO_MOVE(op, 6, 14, 22, 30) NLO_MOVE(op, 7, 15, 23, 31)                  \
      "vstmia %[z]!, {s16-s23}\n"                                                                                  \
      "cmp %[z], %[end]\n"                                                                                         \
      "bne 1b\n"                                                                                                   \
      ".endif\n"                                                                                                   \
      ".rept %c[rest]\n"                                                                                           \
      "vldmia %[t]!, {s0}\n"                                                                                       \
      "vldmia %[target]!, {s8}\n"                                                                                  \
      "vldr s16, [%[z]]\n"                                                                                         \
      "vldr s24, [%[halves]]\n" NLO_MOVE(op, 0, 8, 16, 24)                                                         \
      "vstmia %[z]!, {s16}\n"                                                                                      \
      ".endr\n"                                                                                                    \
      : [t] "+r"(t), [target] "+r"(target), [z] "+r"(z)                                                            \
      : [halves] "r"(kHalves), [end] "r"(z + kN / 8 * 8), [eights] "i"(kN / 8), [rest] "i"(kN % 8)                 \
      : "s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9", "s10", "s11", "s12", "s13", "s14", "s15",      \
        "s16", "s17", "s18", "s19", "s20", "s21", "s22", "s23", "s24", "s25", "s26", "s27", "s28", "s29", "s30",   \
        "s31", "cc", "memory")

/// Computes move_units_plain(). Not inlined for the same reason.
template <bool kFused, int kN>
__attribute__((noinline)) void move_units(const float* t, const float* target, float* z) {
  if constexpr (kFused) {
    NLO_MOVES(NLO_FUSED);
  } else {
    NLO_MOVES(NLO_ROUNDED);
  }
}

#undef NLO_MOVES
#undef NLO_RESETS
#undef NLO_MOVE
#undef NLO_RESET
#undef NLO_ROUNDED
#undef NLO_FUSED

#endif

}  // namespace nlo::inline NLO_ISA::kernels::cortex_m
