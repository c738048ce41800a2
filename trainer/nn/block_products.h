// SPDX-License-Identifier: MIT
// The matrix products of network_block.cpp, over blocks that stay in cache: W a, W^T dv and dv a^T in tiles that fill
// the SIMD registers. `Scalar` float or double, `kColumns` samples.
#pragma once

#include <algorithm>

#include "nlo/kernels/simd.h"
#include "trainer/nn/lane_sums.h"
#include "trainer/nn/network_block.h"

namespace nlo::trainer {

/// Products over blocks: rows x columns times columns x kColumns.
template <class Scalar, int kColumns>
struct Products {
  static constexpr int kWidth = NetworkBlock<Scalar, kColumns>::kWidth;
  static constexpr int kStride = NetworkBlock<Scalar, kColumns>::kStride;
  static constexpr int kPacks = kColumns >= 2 * kWidth ? 2 : 1;  // registers of samples a tile is wide
  using P = simd::Pack<Scalar, kWidth>;
  static_assert(kColumns % (kPacks * kWidth) == 0);

  /// One tile: kRows rows of W times kPacks registers of samples. `finish(row, pack, sum)` takes each result.
  template <int kRows, class Finish>
  static NLO_INLINE void product_tile(const Scalar* w, int columns, const Scalar* bias, const Scalar* in,
                                      const Finish& finish) {
    P sums[kRows][kPacks];
    for (int r = 0; r < kRows; ++r) {
      for (P& sum : sums[r]) sum = simd::broadcast<P>(bias != nullptr ? bias[r] : Scalar(0));
    }
    for (int c = 0; c < columns; ++c) {
      P inputs[kPacks];
      for (int p = 0; p < kPacks; ++p) {
        inputs[p] = simd::load<P>(in + c * kStride + p * kWidth);
        simd::pin(inputs[p]);
      }
      for (int r = 0; r < kRows; ++r) {
        const P weight = simd::broadcast<P>(w[r * columns + c]);
        for (int p = 0; p < kPacks; ++p) sums[r][p] += weight * inputs[p];
      }
    }
    for (int r = 0; r < kRows; ++r) {
      for (int p = 0; p < kPacks; ++p) finish(r, p, sums[r][p]);
    }
  }

  /// out = finish(W in + bias) over a block: `rows` x `columns` times `columns` x kColumns.
  /// Rows are shared out evenly over tiles of at most six: 12 sums, the inputs and a weight fill 16 registers.
  template <class Finish>
  static void product(const Scalar* w, int rows, int columns, const Scalar* bias, const Scalar* in,
                      const Finish& finish) {
    constexpr int kMaxRows = 6;
    const int tiles = (rows + kMaxRows - 1) / kMaxRows;
    for (int s = 0; s < kColumns; s += kPacks * kWidth) {
      int row = 0;
      for (int t = 0; t < tiles; ++t) {
        const int take = (rows - row) / (tiles - t) + ((rows - row) % (tiles - t) != 0 ? 1 : 0);
        const Scalar* tile_w = w + row * columns;
        const Scalar* tile_bias = bias != nullptr ? bias + row : nullptr;
        const auto tile_finish = [&](int r, int p, P sum) NLO_INLINE_LAMBDA { finish(row + r, s + p * kWidth, sum); };
        switch (take) {
          case 6:
            product_tile<6>(tile_w, columns, tile_bias, in + s, tile_finish);
            break;
          case 5:
            product_tile<5>(tile_w, columns, tile_bias, in + s, tile_finish);
            break;
          case 4:
            product_tile<4>(tile_w, columns, tile_bias, in + s, tile_finish);
            break;
          case 3:
            product_tile<3>(tile_w, columns, tile_bias, in + s, tile_finish);
            break;
          case 2:
            product_tile<2>(tile_w, columns, tile_bias, in + s, tile_finish);
            break;
          default:
            product_tile<1>(tile_w, columns, tile_bias, in + s, tile_finish);
            break;
        }
        row += take;
      }
    }
  }

  /// Sums over a block's samples are wanted for each weight. In wide blocks each tile adds up its lanes: to keep a
  /// register of lanes for each weight until the end would push the block out of the cache (500 kB for the paper's
  /// T*). Narrow blocks run thousands of times per gradient, and their sums are too short for that.
  static constexpr bool kKeepsLanes = kColumns < 8 * kWidth;
  static constexpr int kLanesPerWeight = kKeepsLanes ? kWidth : 1;

  /// Adds sum_s dv[o][s] a[i][s] to the gradient of W[o][i], for kRows x kTile entries of W.
  template <int kRows, int kTile>
  static NLO_INLINE void outer_tile(const Scalar* dv, const Scalar* a, Scalar* gradient, int columns) {
    constexpr int kRegisters = (kRows * kTile + kWidth - 1) / kWidth;
    P sums[kRegisters * kWidth] = {};
    for (int s = 0; s < kColumns; s += kWidth) {
      P inputs[kTile];
      for (int c = 0; c < kTile; ++c) {
        inputs[c] = simd::load<P>(a + c * kStride + s);
        simd::pin(inputs[c]);
      }
      for (int r = 0; r < kRows; ++r) {
        P row = simd::load<P>(dv + r * kStride + s);
        simd::pin(row);
        for (int c = 0; c < kTile; ++c) sums[r * kTile + c] += row * inputs[c];
      }
    }
    if constexpr (kKeepsLanes) {
      for (int i = 0; i < kRows * kTile; ++i) {
        Scalar* lanes = gradient + (i / kTile * columns + i % kTile) * kWidth;
        simd::store(lanes, simd::load<P>(lanes) + sums[i]);
      }
    } else {
      Scalar totals[kRegisters * kWidth];
      add_up<kRegisters>(sums, totals);
      for (int i = 0; i < kRows * kTile; ++i) gradient[i / kTile * columns + i % kTile] += totals[i];
    }
  }

  /// totals[i] = the sum of the lanes of sums[i].
  template <int kRegisters>
  static NLO_INLINE void add_up(const P* sums, Scalar* totals) {
    for (int g = 0; g < kRegisters; ++g) {
      P group[kWidth];
      for (int i = 0; i < kWidth; ++i) group[i] = sums[g * kWidth + i];
      simd::store(totals + g * kWidth, lane_sums(group));
    }
  }

  template <int kRows>
  static void outer_rows(const Scalar* dv, const Scalar* a, Scalar* gradient, int columns) {
    // As many sums as fill registers after adding up their lanes; 32 registers hold sixteen.
    constexpr int kTile = kKeepsLanes ? 3 : kWidth >= 16 ? 4 : 2;
    int c = 0;
    for (; c + kTile <= columns; c += kTile)
      outer_tile<kRows, kTile>(dv, a + c * kStride, gradient + c * kLanesPerWeight, columns);
    if constexpr (kTile == 4) {
      if (columns - c == 3) outer_tile<kRows, 3>(dv, a + c * kStride, gradient + c * kLanesPerWeight, columns);
    }
    if constexpr (kTile >= 3) {
      if (columns - c == 2) outer_tile<kRows, 2>(dv, a + c * kStride, gradient + c * kLanesPerWeight, columns);
    }
    if (columns - c == 1) outer_tile<kRows, 1>(dv, a + c * kStride, gradient + c * kLanesPerWeight, columns);
  }

  /// Gradient of a product's weights: dv a^T.
  static void outer_product(const Scalar* dv, int rows, const Scalar* a, int columns, Scalar* gradient) {
    int r = 0;
    for (; r + 4 <= rows; r += 4) outer_rows<4>(dv + r * kStride, a, gradient + r * columns * kLanesPerWeight, columns);
    const Scalar* rest = dv + r * kStride;
    Scalar* rest_gradient = gradient + r * columns * kLanesPerWeight;
    if (rows - r == 3) outer_rows<3>(rest, a, rest_gradient, columns);
    if (rows - r == 2) outer_rows<2>(rest, a, rest_gradient, columns);
    if (rows - r == 1) outer_rows<1>(rest, a, rest_gradient, columns);
  }

  /// Gradient of a product's bias: each row's sum.
  static void row_sums(const Scalar* dv, int rows, Scalar* gradient) {
    const auto sum_of = [dv](int row) {
      P sum{};
      for (int s = 0; s < kColumns; s += kWidth) sum += simd::load<P>(dv + row * kStride + s);
      return sum;
    };
    if constexpr (kKeepsLanes) {
      for (int r = 0; r < rows; ++r) {
        Scalar* lanes = gradient + r * kWidth;
        simd::store(lanes, simd::load<P>(lanes) + sum_of(r));
      }
    } else {
      for (int first = 0; first < rows; first += kWidth) {
        const int count = std::min(kWidth, rows - first);
        P sums[kWidth] = {};
        for (int r = 0; r < count; ++r) sums[r] = sum_of(first + r);
        Scalar totals[kWidth];
        add_up<1>(sums, totals);
        for (int r = 0; r < count; ++r) gradient[first + r] += totals[r];
      }
    }
  }
};

}  // namespace nlo::trainer
