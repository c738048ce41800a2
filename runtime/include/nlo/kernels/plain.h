// SPDX-License-Identifier: MIT
// A dense layer, out = f(W in + b), in plain C++ for targets without vectors: small code with sums in registers. The
// order of the weights is
//   column-major  in layers with 8 or more outputs: [kIn][kOut]
//   row-major     in smaller layers: [kOut][kIn], one dot product per output
// Each output is summed in the order of the inputs, in both policies.
#pragma once

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"

namespace nlo::inline NLO_ISA::kernels::plain {

template <int kOut>
inline constexpr bool kColumnMajor = kOut >= 8;

/// Number of outputs that are summed together: one if operations on floats are function calls, because further sums
/// would be on the stack.
#if defined(__ARM_ARCH_PROFILE) && !defined(__ARM_FP)
inline constexpr int kSums = 1;
#else
inline constexpr int kSums = 4;
#endif

template <int kIn, int kOut>
constexpr int weight_position(int o, int i) {
  return kColumnMajor<kOut> ? i * kOut + o : o * kIn + i;
}

template <Activation kKind, Arithmetic kArithmetic, bool kLast, class Scalar>
NLO_INLINE Scalar finished(Scalar sum) {
  if constexpr (kLast) {
    return sum;
  } else {
    return activate<kKind, kArithmetic>(sum);
  }
}

/// Sums kCount outputs together; their sums fit into registers.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut, int kCount, class Weight,
          class Scalar>
NLO_INLINE void columns(const Weight* weights, const Scalar* bias, const Scalar* in, Scalar* out) {
  Scalar sums[kCount];
  NLO_UNROLL
  for (int o = 0; o < kCount; ++o) sums[o] = bias[o];
  for (int i = 0; i < kIn; ++i) {
    NLO_UNROLL
    for (int o = 0; o < kCount; ++o) {
      sums[o] = multiply_add<kArithmetic, Scalar>(in[i], static_cast<Scalar>(weights[i * kOut + o]), sums[o]);
    }
  }
  NLO_UNROLL
  for (int o = 0; o < kCount; ++o) out[o] = finished<kKind, kArithmetic, kLast>(sums[o]);
}

/// out = f(W in + b). `out` must not overlap `in`. On targets with little flash, layers of equal size share the code.
template <Activation kKind, Arithmetic kArithmetic, bool kLast, int kIn, int kOut, class Weight, class Scalar>
NLO_OWN_FRAME inline void layer(const Weight* weights, const Scalar* bias, const Scalar* in, Scalar* out) {
  if constexpr (kColumnMajor<kOut>) {
    constexpr int kCount = kSums, kLeft = kOut % kCount;
    int o = 0;
    for (; o + kCount <= kOut; o += kCount) {
      columns<kKind, kArithmetic, kLast, kIn, kOut, kCount>(weights + o, bias + o, in, out + o);
    }
    if constexpr (kLeft > 0) {
      columns<kKind, kArithmetic, kLast, kIn, kOut, kLeft>(weights + o, bias + o, in, out + o);
    }
  } else {
    for (int o = 0; o < kOut; ++o) {
      Scalar sum = bias[o];
      for (int i = 0; i < kIn; ++i) {
        sum = multiply_add<kArithmetic, Scalar>(static_cast<Scalar>(weights[o * kIn + i]), in[i], sum);
      }
      out[o] = finished<kKind, kArithmetic, kLast>(sum);
    }
  }
}

}  // namespace nlo::inline NLO_ISA::kernels::plain
