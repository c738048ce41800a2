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

template <Activation kKind>
struct Activate {
  template <class T>
  NLO_INLINE constexpr T operator()(T v) const {
    return activate<kKind>(v);
  }
};

/// kBlocks registers of outputs, the first at output `first`; each next one kLanes on.
template <class Scalar, class P, int kIn, int kOut, int kBlocks, class Function>
NLO_INLINE void columns_block(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out, int first,
                              Function function) {
  constexpr int kWidth = sizeof(P) / sizeof(Scalar);
  // Few registers leave the multiply-add units waiting for each other: split the sum over even and odd inputs.
  constexpr int kSums = kBlocks <= 4 ? 2 : 1;
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
      for (int b = 0; b < kBlocks; ++b) sums[s][b] += input * simd::load<P>(column + (i + s) * kOut + b * kWidth);
    }
  }
  for (; i < kIn; ++i) {
    const P input = simd::broadcast<P>(in[i]);
    for (int b = 0; b < kBlocks; ++b) sums[0][b] += input * simd::load<P>(column + i * kOut + b * kWidth);
  }
  for (int b = 0; b < kBlocks; ++b) {
    P total = sums[0][b];
    for (int s = 1; s < kSums; ++s) total += sums[s][b];
    simd::store(out + first + b * kWidth, function(total));
  }
}

template <class Scalar, int kIn, int kOut, class Function>
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
    columns_block<Scalar, P, kIn, kOut, kMaxBlocks>(weights, bias, in, out, f * kMaxBlocks * kWidth, function);
  }
  constexpr int kLeft = kWhole % kMaxBlocks;
  if constexpr (kLeft > 0) {
    columns_block<Scalar, P, kIn, kOut, kLeft>(weights, bias, in, out, kFull * kMaxBlocks * kWidth, function);
  }
  if constexpr (kRest > 0) {
    columns_block<Scalar, P, kIn, kOut, 1>(weights, bias, in, out, kOut - kWidth, function);
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
template <class Scalar, int kIn, int kOut, class Function>
NLO_INLINE void dense(const Scalar* weights, const Scalar* bias, const Scalar* in, Scalar* out, Function function) {
  if constexpr (kByColumns<kIn, kOut>) {
    by_columns<Scalar, kIn, kOut>(weights, bias, in, out, function);
  } else {
    by_rows<Scalar, kIn, kOut>(weights, bias, in, out, function);
  }
}

}  // namespace nlo::kernels
