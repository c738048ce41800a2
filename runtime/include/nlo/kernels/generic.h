// SPDX-License-Identifier: MIT
// Matrix-vector product of one dense layer, out = activation(W in + b), for any shape and any target.
//
// Two layouts, chosen by the shape alone (never by the target: a model's bytes must not depend on compiler flags):
//   columns  wide layers. One run of kOut weights per input; outputs stay in registers while inputs stream by.
//            A last, partial register is made whole by overlapping its neighbour: no padding, as padded weights of
//            the usual 50 x 50 layers fall out of a 32 KB L1 cache.
//   rows     narrow layers (kOut < 8): a dot product per output.
#pragma once

#include "nlo/activation.h"
#include "nlo/arithmetic.h"
#include "nlo/simd.h"

namespace nlo::kernels {

/// Weights lie by columns ([kIn][kOut]) rather than by rows ([kOut][kIn]).
template <int kIn, int kOut>
inline constexpr bool kByColumns = kOut >= 8;

struct Identity {
  template <class T>
  NLO_INLINE constexpr T operator()(T v) const {
    return v;
  }
};

template <Activation kKind, Arithmetic kArithmetic = Arithmetic::kFast>
struct Activate {
  template <class T>
  NLO_INLINE constexpr T operator()(T v) const {
    return activate<kKind, kArithmetic>(v);
  }
};

/// kBlocks registers of outputs, the first at output `first`; each next one kLanes on.
template <Arithmetic kArithmetic, class Scalar, class P, int kIn, int kOut, int kBlocks, class Function>
NLO_INLINE void columns_block(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out, int first,
                              Function function) {
  constexpr int kWidth = sizeof(P) / sizeof(Scalar);
  // Few registers leave the multiply-add units waiting for each other: split the sum over even and odd inputs. How many
  // registers there are depends on the target, so the deterministic policy does not.
  constexpr int kSums = kArithmetic == Arithmetic::kFast && kBlocks <= 4 ? 2 : 1;
  P sums[kSums][kBlocks];
  for (int b = 0; b < kBlocks; ++b) {
    sums[0][b] = simd::load<P>(bias + first + b * kWidth);
    for (int s = 1; s < kSums; ++s) sums[s][b] = P{};
  }
  const Scalar* column = weights + first;
  int i = 0;
  for (; i + kSums <= kIn; i += kSums) {
    for (int s = 0; s < kSums; ++s) {
      const P input = simd::broadcast<P>(in[i + s]);
      for (int b = 0; b < kBlocks; ++b) {
        const P weight = simd::load<P>(column + (i + s) * kOut + b * kWidth);
        sums[s][b] = multiply_add<kArithmetic, P>(input, weight, sums[s][b]);
      }
    }
  }
  for (; i < kIn; ++i) {
    const P input = simd::broadcast<P>(in[i]);
    for (int b = 0; b < kBlocks; ++b) {
      const P weight = simd::load<P>(column + i * kOut + b * kWidth);
      sums[0][b] = multiply_add<kArithmetic, P>(input, weight, sums[0][b]);
    }
  }
  for (int b = 0; b < kBlocks; ++b) {
    P total = sums[0][b];
    for (int s = 1; s < kSums; ++s) total += sums[s][b];
    simd::store(out + first + b * kWidth, function(total));
  }
}

template <Arithmetic kArithmetic, class Scalar, int kIn, int kOut, class Function>
NLO_INLINE void by_columns(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out,
                           Function function) {
  constexpr int kTargetLanes = simd::kLanes<Scalar>;
  constexpr int kWidth = kTargetLanes <= kOut ? kTargetLanes : 8;  // layers of 8 to 15 outputs on 16-lane targets
  using P = simd::Pack<Scalar, kWidth>;
  constexpr int kWhole = kOut / kWidth;
  constexpr int kRest = kOut % kWidth;
  constexpr int kMaxBlocks = kWidth == 1 ? 4 : 8;
  constexpr int kFull = kWhole / kMaxBlocks;
  for (int f = 0; f < kFull; ++f) {
    columns_block<kArithmetic, Scalar, P, kIn, kOut, kMaxBlocks>(weights, bias, in, out, f * kMaxBlocks * kWidth,
                                                                 function);
  }
  constexpr int kLeft = kWhole % kMaxBlocks;
  if constexpr (kLeft > 0) {
    columns_block<kArithmetic, Scalar, P, kIn, kOut, kLeft>(weights, bias, in, out, kFull * kMaxBlocks * kWidth,
                                                            function);
  }
  if constexpr (kRest > 0) {
    columns_block<kArithmetic, Scalar, P, kIn, kOut, 1>(weights, bias, in, out, kOut - kWidth, function);
  }
}

/// The deterministic policy: one sum per output, in the order of the inputs.
template <class Scalar, int kIn, int kOut, class Function>
NLO_INLINE void by_rows_in_order(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out,
                                 Function function) {
  for (int o = 0; o < kOut; ++o) {
    Scalar total = bias[o];
    for (int i = 0; i < kIn; ++i) {
      total = multiply_add<Arithmetic::kDeterministic, Scalar>(weights[o * kIn + i], in[i], total);
    }
    out[o] = function(total);
  }
}

template <class Scalar, int kIn, int kOut, class Function>
NLO_INLINE void by_rows(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out, Function function) {
  constexpr int kWidth = simd::kLanes<Scalar>;
  using P = simd::Pack<Scalar, kWidth>;
  constexpr int kVectored = kIn / kWidth * kWidth;
  for (int o = 0; o < kOut; ++o) {
    const Scalar* row = weights + o * kIn;
    P sums[2] = {};
    int i = 0;
    for (; i + 2 * kWidth <= kVectored; i += 2 * kWidth) {
      sums[0] += simd::load<P>(row + i) * simd::load<P>(in + i);
      sums[1] += simd::load<P>(row + i + kWidth) * simd::load<P>(in + i + kWidth);
    }
    for (; i < kVectored; i += kWidth) sums[0] += simd::load<P>(row + i) * simd::load<P>(in + i);
    Scalar total = bias[o] + simd::sum<Scalar>(sums[0] + sums[1]);
    for (; i < kIn; ++i) total += row[i] * in[i];
    out[o] = function(total);
  }
}

/// out = function(W in + bias). `out` must not overlap `in`.
///   weights  kOut x kIn, in the layout of kByColumns
template <Arithmetic kArithmetic, class Scalar, int kIn, int kOut, class Function>
NLO_INLINE void dense(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out, Function function) {
  if constexpr (kByColumns<kIn, kOut>) {
    by_columns<kArithmetic, Scalar, kIn, kOut>(weights, bias, in, out, function);
  } else if constexpr (kArithmetic == Arithmetic::kDeterministic) {
    by_rows_in_order<Scalar, kIn, kOut>(weights, bias, in, out, function);
  } else {
    by_rows<Scalar, kIn, kOut>(weights, bias, in, out, function);
  }
}
template <class Scalar, int kIn, int kOut, class Function>
NLO_INLINE void dense(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out, Function function) {
  dense<Arithmetic::kFast, Scalar, kIn, kOut>(weights, bias, in, out, function);
}

}  // namespace nlo::kernels
