// SPDX-License-Identifier: MIT
// Matrix-vector product of a dense layer in float32 for RISC-V cores with vectors of floats (V, or Zve32f):
// out = f(W in + b).
//
// The sums of a strip of outputs stay in v8-v15: as many outputs as eight registers hold, 32 if a register has 128
// bits. Inputs are in scalar registers, weights in v16-v31. The order of the weights is that of plain.h, so that a
// model has the same bytes in objects that may use vectors and in others.
//
// fast           VFMACC by a scalar
// deterministic  VFMUL by a scalar, VFADD: each operation rounded by itself, as on every other target
//
// The order of the sums, and therefore the bits, are those of cortex_m::layer_plain() without its table of tanh, for
// any length of the vectors. It is assembly, because GCC 12 cannot generate vector code.
#pragma once

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/plain.h"
#include "nlo/kernels/riscv_state.h"
#include "nlo/kernels/simd.h"

#if defined(NLO_RISCV_VECTORS)

namespace nlo::inline NLO_ISA::kernels::riscv_vectors {

/// Number of registers for a vector of up to kN values. A register holds at least four values.
template <int kN>
inline constexpr int kRegisters = kN <= 4    ? 1
                                  : kN <= 8  ? 2
                                  : kN <= 16 ? 4
                                             : 8;

using plain::weight_position;

// sums += x weights, with x in a scalar register: fused, or rounded twice.
#define NLO_FUSED(weights) "vfmacc.vf v8, ft0, " weights "\n"
#define NLO_ROUNDED(weights)       \
  "vfmul.vf " weights ", " weights \
  ", ft0\n"                        \
  "vfadd.vv v8, v8, " weights "\n"
#define NLO_INPUT(op, offset, weights) \
  "flw ft0, " offset                   \
  "(t1)\n"                             \
  ".if %c[columns]\n"                  \
  "vle32.v " weights                   \
  ", (t2)\n"                           \
  ".else\n"                            \
  "vlse32.v " weights                  \
  ", (t2), %[next_output]\n"           \
  ".endif\n"                           \
  "add t2, t2, %[next_input]\n" op(weights)
#define NLO_INPUT_IF(at_least, op, offset, weights) \
  ".if %c[left] >= " at_least "\n" NLO_INPUT(op, offset, weights) ".endif\n"
#define NLO_STRIPS(op) \
  asm volatile(                                                                                                       \
      "1:\n"                                                                                                          \
      "vsetvli t0, %[outputs], e32, m%c[registers], ta, ma\n"                                                         \
      "vle32.v v8, (%[bias])\n"                                                                                       \
      "mv t1, %[in]\n"                                                                                                \
      "mv t2, %[weights]\n"                                                                                           \
      ".if %c[fives]\n"                                                                                               \
      "2:\n" NLO_INPUT(op, "0", "v16") NLO_INPUT(op, "4", "v24") NLO_INPUT(op, "8", "v16") NLO_INPUT(op, "12", "v24") \
          NLO_INPUT(op, "16", "v16")                                                                                  \
      "addi t1, t1, 20\n"                                                                                             \
      "bne t1, %[fives_end], 2b\n"                                                                                    \
      ".endif\n" NLO_INPUT_IF("1", op, "0", "v24") NLO_INPUT_IF("2", op, "4", "v16") NLO_INPUT_IF("3", op, "8", "v24")\
          NLO_INPUT_IF("4", op, "12", "v16")                                                                          \
      "vse32.v v8, (%[out])\n"                                                                                        \
      "sub %[outputs], %[outputs], t0\n"                                                                              \
      "mul t1, t0, %[next_output]\n"                                                                                  \
      "add %[weights], %[weights], t1\n"                                                                              \
      "slli t0, t0, 2\n"                                                                                              \
      "add %[bias], %[bias], t0\n"                                                                                    \
      "add %[out], %[out], t0\n"                                                                                      \
      "bnez %[outputs], 1b\n"                                                                                         \
      : [weights] "+r"(weights), [bias] "+r"(bias), [out] "+r"(out), [outputs] "+r"(outputs)                          \
      : [in] "r"(in), [fives_end] "r"(in + kIn / 5 * 5), [next_input] "r"(kNextInput),                                \
        [next_output] "r"(kNextOutput), [columns] "i"(kColumns), [fives] "i"(kIn / 5), [left] "i"(kIn % 5),           \
        [registers] "i"(kRegisters<kOut>)                                                                             \
      : "t0", "t1", "t2", "ft0", NLO_RISCV_CLOBBERS)

/// out = bias + W in.
template <bool kFused, int kIn, int kOut>
NLO_INLINE void multiply(const float* weights, const float* bias, const float* in, float* out) {
  constexpr bool kColumns = plain::kColumnMajor<kOut>;
  constexpr long kNextInput = 4 * (kColumns ? kOut : 1), kNextOutput = 4 * (kColumns ? 1 : kIn);  // bytes
  long outputs = kOut;
  if constexpr (kFused) {
    NLO_STRIPS(NLO_FUSED);
  } else {
    NLO_STRIPS(NLO_ROUNDED);
  }
}

// Loads, changes and stores the values at `at`, one strip in v0 at a time.
#define NLO_IN_PLACE(text)                              \
  "1:\n"                                                \
  "vsetvli t0, %[count], e32, m%c[registers], ta, ma\n" \
  "vle32.v v0, (%[at])\n" text                          \
  "vse32.v v0, (%[at])\n"                               \
  "sub %[count], %[count], t0\n"                        \
  "slli t0, t0, 2\n"                                    \
  "add %[at], %[at], t0\n"                              \
  "bnez %[count], 1b\n"

/// Computes max(v, 0) of each value.
template <int kN>
NLO_INLINE void relu_in_place(float* at) {
  long count = kN;
  asm volatile(NLO_IN_PLACE("vfmax.vf v0, v0, %[zero]\n")
               : [at] "+r"(at), [count] "+r"(count)
               : [zero] "f"(0.0F), [registers] "i"(kRegisters<kN>)
               : "t0", NLO_RISCV_CLOBBERS);
}

// sum = first s + second, and sum = sum s + next, with s = x^2 in v8; v24 is scratch.
#define NLO_FUSED_FIRST(sum, first, second) \
  "vfmv.v.f " sum ", " second               \
  "\n"                                      \
  "vfmacc.vf " sum ", " first ", v8\n"
#define NLO_ROUNDED_FIRST(sum, first, second) \
  "vfmul.vf " sum ", v8, " first              \
  "\n"                                        \
  "vfadd.vf " sum ", " sum ", " second "\n"
#define NLO_FUSED_STEP(sum, next) \
  "vfmv.v.f v24, " next           \
  "\n"                            \
  "vfmadd.vv " sum ", v8, v24\n"
#define NLO_ROUNDED_STEP(sum, next) \
  "vfmul.vv " sum ", " sum          \
  ", v8\n"                          \
  "vfadd.vf " sum ", " sum ", " next "\n"
#define NLO_POLYNOMIAL(op, c) \
  ".if %c[terms] == 5\n" op##_FIRST("v16", "%[" #c "4]", "%[" #c "3]")                    \
      op##_STEP("v16", "%[" #c "2]")                                                      \
  ".elseif %c[terms] == 4\n" op##_FIRST("v16", "%[" #c "3]", "%[" #c "2]")                \
  ".endif\n"                                                                              \
  ".if %c[terms] == 3\n" op##_FIRST("v16", "%[" #c "2]", "%[" #c "1]")                    \
  ".else\n" op##_STEP("v16", "%[" #c "1]")                                                \
  ".endif\n" op##_STEP("v16", "%[" #c "0]")
// silu: tanh of half the value, multiplied by that half, plus that half.
#define NLO_FUSED_SILU "vfmadd.vv v0, v8, v8\n"
#define NLO_ROUNDED_SILU  \
  "vfmul.vv v0, v0, v8\n" \
  "vfadd.vv v0, v0, v8\n"
#define NLO_TANH(op)                                                                                                   \
  asm volatile(                                                                                                        \
      NLO_IN_PLACE(".if %c[silu]\n"                                                                                    \
                   "vfmul.vf v0, v0, %[half]\n"                                                                        \
                   ".endif\n"                                                                                          \
                   "vfmin.vf v0, v0, %[limit]\n"                                                                       \
                   "vfmax.vf v0, v0, %[lower]\n"                                                                       \
                   "vfmul.vv v8, v0, v0\n" NLO_POLYNOMIAL(op, p) "vfmul.vv v0, v0, v16\n" NLO_POLYNOMIAL(              \
                       op, q) "vfdiv.vv v0, v0, v16\n"                                                                 \
                              ".if %c[silu]\n"                                                                         \
                              "vle32.v v8, (%[at])\n"                                                                  \
                              "vfmul.vf v8, v8, %[half]\n" op##_SILU ".endif\n")                                       \
      : [at] "+r"(at), [count] "+r"(count)                                                                             \
      : [limit] "f"(kFit.limit), [lower] "f"(-kFit.limit), [half] "f"(0.5F), [p0] "f"(kFit.p[0]), [p1] "f"(kFit.p[1]), \
        [p2] "f"(kFit.p[2]), [p3] "f"(kFit.p[k3]), [p4] "f"(kFit.p[k4]), [q0] "f"(kFit.q[0]), [q1] "f"(kFit.q[1]),     \
        [q2] "f"(kFit.q[2]), [q3] "f"(kFit.q[k3]), [q4] "f"(kFit.q[k4]), [terms] "i"(kTerms),                          \
        [silu] "i"(kKind == Activation::kSilu), [registers] "i"(kRegisters<kN>)                                        \
      : "t0", NLO_RISCV_CLOBBERS)

/// Computes cortex_m::activate_plain() of kN values, in place. tanh takes 27 instructions per strip.
template <Activation kKind, bool kFused, int kN>
NLO_INLINE void tanh_in_place(float* at) {
  constexpr const auto& kFit = kTanhFit<kKind, float>;
  constexpr int kTerms = kFit.kTerms, k3 = kTerms > 3 ? 3 : 2, k4 = kTerms > 4 ? 4 : 2;
  static_assert(kTerms >= 3 && kTerms <= 5);
  long count = kN;
  if constexpr (kFused) {
    NLO_TANH(NLO_FUSED);
  } else {
    NLO_TANH(NLO_ROUNDED);
  }
}

/// out = f(W in + b). `out` must not overlap `in`. Not inlined, so that layers of equal size share the code.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut>
__attribute__((noinline)) void layer(const float* weights, const float* bias, const float* in, float* out) {
  constexpr bool kFused = kArithmetic == Arithmetic::kFast;
  multiply<kFused, kIn, kOut>(weights, bias, in, out);
  if constexpr (!kLast) {
    if constexpr (kKind == Activation::kRelu) {
      relu_in_place<kOut>(out);
    } else {
      tanh_in_place<kKind, kFused, kOut>(out);
    }
  }
}

#undef NLO_TANH
#undef NLO_ROUNDED_SILU
#undef NLO_FUSED_SILU
#undef NLO_POLYNOMIAL
#undef NLO_ROUNDED_STEP
#undef NLO_FUSED_STEP
#undef NLO_ROUNDED_FIRST
#undef NLO_FUSED_FIRST
#undef NLO_IN_PLACE
#undef NLO_STRIPS
#undef NLO_INPUT_IF
#undef NLO_INPUT
#undef NLO_ROUNDED
#undef NLO_FUSED

}  // namespace nlo::inline NLO_ISA::kernels::riscv_vectors

#endif
