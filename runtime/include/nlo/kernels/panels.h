// SPDX-License-Identifier: MIT
// The layout of a dense layer's weights for CPUs with vectors, whatever the vectors' length: a model's bytes must not
// depend on compiler flags. For each layer, one after the other,
//   tiles   up to 64 outputs each, a multiple of 16: per input the weights of all outputs of the tile, side by side.
//           Sums stay in registers while inputs stream by; every load is of whole, aligned cache lines
//   eight   8 outputs more, likewise
//   rest    up to 7 outputs more, row-major: a dot product each, rows padded with zeros to a multiple of 4. In layers
//           of few inputs column-major: per input, side by side, padded with zeros to a multiple of 4 outputs
// Nothing else is padded: the usual 50 x 50 layers, padded to 64, would fall out of a 32 KB L1 cache.
//
// Vectors of activations are padded with zeros to a multiple of 4, and 64-byte aligned.
#pragma once

#include <type_traits>
#include <utility>

#include "nlo/kernels/activation.h"
#include "nlo/kernels/arithmetic.h"
#include "nlo/kernels/simd.h"

// The architecture has vectors, whether or not the compiler may use them.
#if !defined(NLO_SCALAR_KERNELS) && (defined(__x86_64__) || defined(__SSE2__) || defined(__aarch64__))
#define NLO_HAS_VECTORS 1
#else
#define NLO_HAS_VECTORS 0
#endif

namespace nlo {

/// The type in which a network with such weights computes; weight.h has weights that are of another.
template <class Weight>
struct ComputesIn {
  using Type = Weight;
};

}  // namespace nlo

namespace nlo::kernels {

inline constexpr bool kHasVectors = NLO_HAS_VECTORS == 1;

constexpr int rounded_up(int n, int multiple) {
  return (n + multiple - 1) / multiple * multiple;
}

/// Room that the values of a layer take between layers, the zeros included that kernels put behind them.
constexpr int padded(int values) {
  return kHasVectors ? rounded_up(values, 4) : values;
}

/// The layout of one layer; sizes as values, for generators of headers too.
struct PanelLayout {
  int in, out;

  constexpr int wide() const { return out / 16 * 16; }  ///< outputs in tiles
  constexpr int tiles() const { return (wide() + 63) / 64; }
  constexpr int eight() const { return out - wide() >= 8 ? 8 : 0; }
  constexpr int rest() const { return out - wide() - eight(); }
  constexpr bool rest_is_row_major() const { return in >= 16; }
  constexpr int rest_at() const { return in * (wide() + eight()); }  ///< its first weight
  constexpr int weights() const {
    return rest_at() + (rest_is_row_major() ? rest() * rounded_up(in, 4) : in * rounded_up(rest(), 4));
  }
  constexpr int biases() const { return wide() + eight() + rounded_up(rest(), 4); }  ///< outputs, padded

  /// First output of a tile; of `tiles()`: the end of the last one. Sizes are equal or 16 apart.
  constexpr int tile_at(int tile) const {
    const int parts = tiles() > 0 ? tiles() : 1, each = wide() / 16 / parts, longer = wide() / 16 % parts;
    return 16 * (each * tile + (tile < longer ? tile : longer));
  }

  /// Position of the weight of input i for output o.
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

/// The same, sizes as template parameters.
template <int kIn, int kOut>
struct Panels {
  static constexpr PanelLayout kLayout{kIn, kOut};
  static constexpr int kWeights = kLayout.weights();
  static constexpr int kBiases = kLayout.biases();
  static constexpr int weight_position(int o, int i) { return kLayout.weight_position(o, i); }
};

}  // namespace nlo::kernels

namespace nlo {

/// One layer in this layout. Generators write large layers in it too, as a compiler would take long to rearrange them.
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

}  // namespace nlo

#if NLO_HAS_VECTORS

namespace nlo::kernels {

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

}  // namespace nlo::kernels

#endif
