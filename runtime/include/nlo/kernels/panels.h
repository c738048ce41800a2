// SPDX-License-Identifier: MIT
// Layout of the weights of a dense layer for CPUs with vectors. It does not depend on the length of the vectors,
// because the bytes of a model must not depend on compiler flags. A layer has three parts:
//   tiles   up to 64 outputs each, a multiple of 16. For each input, the weights of all outputs of the tile are side by
//           side. Sums stay in registers during the loop over the inputs; every load reads whole, aligned cache lines
//   eight   8 further outputs, in the same order
//   rest    up to 7 further outputs. Usually row-major: one dot product each, rows padded with zeros to a multiple of
//           4. In layers with few inputs column-major: the weights of all outputs are side by side for each input,
//           padded with zeros to a multiple of 4 outputs
// Nothing else is padded. The usual 50 x 50 layers, padded to 64, would not fit into a 32 KB L1 cache.
//
// Vectors of activations are padded with zeros to a multiple of 4 and aligned to 64 bytes.
#pragma once

#include <type_traits>
#include <utility>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"

// True if the architecture has vectors, even if the compiler may not use them.
#if !defined(NLO_SCALAR_KERNELS) && (defined(__x86_64__) || defined(__SSE2__) || defined(__aarch64__))
#define NLO_HAS_VECTORS 1
#else
#define NLO_HAS_VECTORS 0
#endif

namespace nlo::inline NLO_ISA {

/// Type of the sums of a network with such weights. Weights of 16 bits (weight.h) are converted to float.
template <class Weight>
struct ComputesIn {
  using Type = Weight;
};

}  // namespace nlo::inline NLO_ISA

namespace nlo::inline NLO_ISA::kernels {

inline constexpr bool kHasVectors = NLO_HAS_VECTORS == 1;

constexpr int rounded_up(int n, int multiple) {
  return (n + multiple - 1) / multiple * multiple;
}

/// Returns the size of a buffer for `values` values of a layer and the zeros that kernels append to them.
constexpr int padded(int values) {
  return kHasVectors ? rounded_up(values, 4) : values;
}

/// The layout of one layer, with its sizes as run-time values. The header generator uses it too.
struct PanelLayout {
  int in, out;

  constexpr int wide() const { return out / 16 * 16; }  ///< outputs in tiles
  constexpr int tiles() const { return (wide() + 63) / 64; }
  constexpr int eight() const { return out - wide() >= 8 ? 8 : 0; }
  constexpr int rest() const { return out - wide() - eight(); }
  constexpr bool rest_is_row_major() const { return in >= 16; }
  constexpr int rest_at() const { return in * (wide() + eight()); }  ///< position of the first weight of the rest
  constexpr int weights() const {
    return rest_at() + (rest_is_row_major() ? rest() * rounded_up(in, 4) : in * rounded_up(rest(), 4));
  }
  constexpr int biases() const {
    return wide() + eight() + rounded_up(rest(), 4);
  }  ///< number of biases, padding included

  /// Returns the first output of a tile; for tile = tiles(), the end of the last one. Tile sizes differ by at most 16.
  constexpr int tile_at(int tile) const {
    const int parts = tiles() > 0 ? tiles() : 1, each = wide() / 16 / parts, longer = wide() / 16 % parts;
    return 16 * (each * tile + (tile < longer ? tile : longer));
  }

  /// Returns the position of the weight of input i for output o.
  constexpr int weight_position(int o, int i) const {
    if (o < wide()) {
      int tile = 0;
      while (o >= tile_at(tile + 1)) ++tile;
      const int first = tile_at(tile);
      return first * in + i * (tile_at(tile + 1) - first) + (o - first);
    }
    if (o < wide() + eight()) return wide() * in + i * eight() + (o - wide());
    const int row = o - wide() - eight();
    return rest_at() + (rest_is_row_major() ? row * rounded_up(in, 4) + i : i * rounded_up(rest(), 4) + row);
  }
};

/// The same with sizes as template parameters.
template <int kIn, int kOut>
struct Panels {
  static constexpr PanelLayout kLayout{kIn, kOut};
  static constexpr int kWeights = kLayout.weights();
  static constexpr int kBiases = kLayout.biases();
  static constexpr int weight_position(int o, int i) { return kLayout.weight_position(o, i); }
};

}  // namespace nlo::inline NLO_ISA::kernels

namespace nlo::inline NLO_ISA {

/// A layer in this layout. Generated headers use it for large layers too, because a compiler would take long to pack
/// them.
template <class Weight, int kIn_, int kOut_>
struct PanelDense {
  using Layout = kernels::Panels<kIn_, kOut_>;
  using Scalar = typename ComputesIn<Weight>::Type;
  static constexpr int kIn = kIn_;
  static constexpr int kOut = kOut_;
  alignas(64) Weight weights[Layout::kWeights];
  alignas(64) Scalar bias[Layout::kBiases];
  constexpr Weight weight(int o, int i) const { return weights[Layout::weight_position(o, i)]; }
};

}  // namespace nlo::inline NLO_ISA

#if NLO_HAS_VECTORS

namespace nlo::inline NLO_ISA::kernels {

namespace native {
using namespace nlo::simd;
using nlo::native::activate;
#define NLO_CODE NLO_INLINE
#define NLO_CODE_SHARED __attribute__((noinline))
#define NLO_ISA_BYTES NLO_NATIVE_BYTES
#include "nlo/kernels/per_isa/panels.inc"
#undef NLO_ISA_BYTES
#undef NLO_CODE_SHARED
#undef NLO_CODE
}  // namespace native

}  // namespace nlo::inline NLO_ISA::kernels

#endif
