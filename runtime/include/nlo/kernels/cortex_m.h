// SPDX-License-Identifier: MIT
// Matrix-vector product of a dense layer in float32 for Cortex-M cores with an FPU (M4F, M7, M33): out = f(W in + b).
//
// These cores have 32 registers and one load port, so the number of instructions per weight decides the time. A block
// has 13 outputs, whose sums stay in s0-s12. One multiple-register load reads 13 weights, another one 5 inputs. Weights
// are stored in the order in which they are read. On the paper's 50 x 50 layers this takes 1.11 instructions per
// multiply-add; compiled loops take 3.
//
// fast           VFMA: one instruction per multiply-add, on every core.
// deterministic  VMLA: the product is rounded, then the sum, as on every other target.
// Arm's manual of the M4 lists 3 cycles for each of these, and 1 cycle for each of VMUL and VADD. On an M4 the latter
// pair may therefore be faster. Measure it on your chip; NLO_CORTEX_M_NO_FMA selects it.
//
// layer_plain() gives the same bits in C++ on any machine.
#pragma once

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/cortex_m_pieces.h"
#include "nlo/kernels/cortex_m_registers.h"
#include "nlo/kernels/simd.h"

namespace nlo::inline NLO_ISA::kernels::cortex_m {

/// Divides kAll into as few parts of at most kMost as possible; their sizes differ by at most one: 50 = 13 + 13 + 12 +
/// 12.
template <int kAll, int kMost>
struct Parts {
  static constexpr int kCount = (kAll + kMost - 1) / kMost;
  static constexpr int kSmall = kAll / kCount;
  static constexpr int kLargeCount = kAll % kCount;  ///< number of parts that are larger by one; they come first
  static constexpr int kLarge = kSmall + (kLargeCount > 0 ? 1 : 0);
  static constexpr int size(int part) { return kSmall + (part < kLargeCount ? 1 : 0); }
  static constexpr int first(int part) { return part * kSmall + (part < kLargeCount ? part : kLargeCount); }
  static constexpr int part_of(int one) {
    int part = 0;
    while (one >= first(part) + size(part)) ++part;
    return part;
  }
};

/// The blocks of the outputs.
template <int kOut>
using Blocks = Parts<kOut, 13>;

/// Returns the position of the weight of input i for output o: block by block, then input by input.
template <int kIn, int kOut>
constexpr int weight_position(int o, int i) {
  using B = Blocks<kOut>;
  const int block = B::part_of(o);
  return B::first(block) * kIn + i * B::size(block) + (o - B::first(block));
}

#if defined(NLO_CORTEX_M_NO_FMA)
inline constexpr bool kFuses = false;
#else
inline constexpr bool kFuses = true;
#endif

/// Returns a b + c as the kernel computes it: fused, or with two roundings.
template <Arithmetic kArithmetic>
NLO_INLINE float kernel_multiply_add(float a, float b, float c) {
  if constexpr (kArithmetic == Arithmetic::kFast && kFuses) {
    return __builtin_fmaf(a, b, c);
  } else {
    return rounded(a * b) + c;
  }
}

/// True if a layer computes tanh by the table of cortex_m_pieces.h.
template <Activation kKind, Arithmetic kArithmetic, int kIn, int kOut>
inline constexpr bool kByPieces =
    kKind == Activation::kTanh&& kArithmetic == Arithmetic::kFast&& kFuses&& kTakesPieces<kIn, kOut>;

template <Activation kKind, Arithmetic kArithmetic>
float activate_plain(float v) {
  if constexpr (kKind == Activation::kRelu) {
    return v > 0.0F ? v : 0.0F;
  } else if constexpr (kKind == Activation::kSilu) {
    const float half = v * 0.5F;
    return kernel_multiply_add<kArithmetic>(half, activate_plain<Activation::kTanh, kArithmetic>(half), half);
  } else {
    constexpr const auto& kFit = kTanhFit<kKind, float>;
    constexpr int kP = sizeof kFit.p / sizeof(float) - 1, kQ = sizeof kFit.q / sizeof(float) - 1;
    const float x = v < kFit.limit ? (v > -kFit.limit ? v : -kFit.limit) : kFit.limit;
    const float s = x * x;
    float p = kFit.p[kP], q = kFit.q[kQ];
    for (int k = kP - 1; k >= 0; --k) p = kernel_multiply_add<kArithmetic>(p, s, kFit.p[k]);
    for (int k = kQ - 1; k >= 0; --k) q = kernel_multiply_add<kArithmetic>(q, s, kFit.q[k]);
    return x * p / q;
  }
}

/// Computes the same as layer() in plain C++. kLast: without activation.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut,
          bool kPieces = kByPieces<kKind, kArithmetic, kIn, kOut>>
void layer_plain(const float* weights, const float* bias, const float* in, float* out) {
  for (int o = 0; o < kOut; ++o) {
    float sum = bias[o];
    for (int i = 0; i < kIn; ++i) {
      sum = kernel_multiply_add<kArithmetic>(weights[weight_position<kIn, kOut>(o, i)], in[i], sum);
    }
    if constexpr (kLast) {
      out[o] = sum;
    } else if constexpr (kPieces) {
      out[o] = tanh_by_pieces_plain(sum);
    } else {
      out[o] = activate_plain<kKind, kArithmetic>(sum);
    }
  }
}

#if defined(NLO_CORTEX_M_FLOAT)

/// out = f(W in + b). `out` must not overlap `in`. Not inlined, so that layers of equal size share the code.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut>
__attribute__((noinline)) void layer(const float* weights, const float* bias, const float* in, float* out) {
  constexpr bool kFused = kArithmetic == Arithmetic::kFast && kFuses;
  using B = Blocks<kOut>;
  float* const large_end = out + B::kLargeCount * B::kLarge;
  float* const end = out + kOut;
  while (out != large_end) multiply_block<B::kLarge, kFused, kIn>(weights, bias, in, out);
  while (out != end) multiply_block<B::kSmall, kFused, kIn>(weights, bias, in, out);
  out -= kOut;
  if constexpr (!kLast) {
    if constexpr (kByPieces<kKind, kArithmetic, kIn, kOut>) {
      tanh_by_pieces<kOut>(out);
    } else if constexpr (kKind == Activation::kTanh) {
      tanh_in_place<kFused, kOut>(out);
    } else if constexpr (kKind == Activation::kRelu) {
      relu_in_place<kOut>(out);
    } else {
      for (int o = 0; o < kOut; ++o) out[o] = activate_plain<kKind, kArithmetic>(out[o]);
    }
  }
}

#endif

}  // namespace nlo::inline NLO_ISA::kernels::cortex_m
