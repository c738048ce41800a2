// SPDX-License-Identifier: MIT
// The matrix products of network_block.cpp, over blocks that stay in cache: W a, W^T dv and dv a^T in tiles that fill
// the SIMD registers. `Scalar` float or double, `kColumns` samples.
#pragma once

#include <algorithm>
#include <bit>
#include <type_traits>
#include <utility>

#include "nlo/kernels/simd.h"
#include "trainer/base/even_parts.h"
#include "trainer/gradients/nn/lane_sums.h"
#include "trainer/gradients/nn/network_block.h"

namespace nlo::trainer {

/// Products over blocks: rows x columns times columns x kColumns.
template <class Scalar, int kColumns>
struct Products {
  static constexpr int kWidth = NetworkBlock<Scalar, kColumns>::kWidth;
  static constexpr int kStride = NetworkBlock<Scalar, kColumns>::kStride;
  static constexpr int kPacks = kColumns >= 2 * kWidth ? 2 : 1;  // width of a tile in registers of samples
  using P = simd::Pack<Scalar, kWidth>;
  static_assert(kColumns % (kPacks * kWidth) == 0);

  /// The layout of W: its entries are at[row * per_row + column * per_column].
  struct Weights {
    const Scalar* at;
    int per_row, per_column;
  };

  /// Computes one tile: kRows rows of W times kPacks registers of samples. `finish(row, pack, sum)` gets each result.
  template <int kRows, class Finish>
  static NLO_INLINE void product_tile(Weights w, int columns, const Scalar* bias, const Scalar* in,
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
        const P weight = simd::broadcast<P>(w.at[r * w.per_row + c * w.per_column]);
        for (int p = 0; p < kPacks; ++p) sums[r][p] += weight * inputs[p];
      }
    }
    for (int r = 0; r < kRows; ++r) {
      for (int p = 0; p < kPacks; ++p) finish(r, p, sums[r][p]);
    }
  }

  /// Computes out = finish(W in + bias) over a block: `rows` x `columns` times `columns` x kColumns. A tile has at most
  /// 12 sums: with the inputs and a weight they fill 16 registers, and eight sums hide the latency of the multiply-add
  /// units.
  template <class Finish>
  static void product(const Scalar* w, int rows, int columns, const Scalar* bias, const Scalar* in,
                      const Finish& finish) {
    for (int s = 0; s < kColumns; s += kPacks * kWidth) {
      in_even_parts<12 / kPacks>(rows, [&](auto count, int row) NLO_INLINE_LAMBDA {
        product_tile<count()>({w + row * columns, columns, 1}, columns, bias != nullptr ? bias + row : nullptr, in + s,
                              [&](int r, int p, P sum) NLO_INLINE_LAMBDA { finish(row + r, s + p * kWidth, sum); });
      });
    }
  }

  /// out = W in + bias, or out += W in (kAdds, without a bias), over a block. All layers of a network share this
  /// function's tiles. The caller applies the activation in a second pass, which costs a load and a store per sum.
  /// Tiles with the activation inside were compiled once per activation, which took 40 s.
  template <bool kAdds = false>
  [[gnu::noinline]] static void multiply(const Scalar* w, int rows, int columns, const Scalar* bias, const Scalar* in,
                                         Scalar* out) {
    product(w, rows, columns, bias, in, [=](int row, int s, P v) NLO_INLINE_LAMBDA {
      Scalar* at = out + row * kStride + s;
      simd::store(at, kAdds ? simd::load<P>(at) + v : v);
    });
  }

  /// Computes the product from W by columns: W[row][c] = w[c * stride + row]. If a register holds two rows of a narrow
  /// block, a multiply-add takes sixteen rows of W and one sample, and the sums are transposed at the end.
  template <class Finish>
  static void product_by_columns(const Scalar* w, int stride, int rows, int columns, const Scalar* bias,
                                 const Scalar* in, const Finish& finish) {
    int row = 0;
    if constexpr (kTurns) {
      for (; row + 2 * kTurned <= rows; row += 2 * kTurned)
        turned_tile<2>(w + row, stride, columns, bias != nullptr ? bias + row : nullptr, in, row, finish);
      for (; row + kTurned <= rows; row += kTurned)
        turned_tile<1>(w + row, stride, columns, bias != nullptr ? bias + row : nullptr, in, row, finish);
    }
    for (int s = 0; s < kColumns; s += kPacks * kWidth) {
      in_even_parts<12 / kPacks>(rows - row, [&](auto count, int first) NLO_INLINE_LAMBDA {
        const int at = row + first;
        product_tile<count()>({w + at, 1, stride}, columns, bias != nullptr ? bias + at : nullptr, in + s,
                              [&](int r, int p, P sum) NLO_INLINE_LAMBDA { finish(at + r, s + p * kWidth, sum); });
      });
    }
  }

  static constexpr int kTurned = simd::kLanes<Scalar>;  // rows of W in a register
  static constexpr bool kTurns = kColumns == 8 && kTurned == 16;

  /// Computes kRegisters x 16 rows of W times a block of eight samples.
  template <int kRegisters, class Finish>
  static NLO_INLINE void turned_tile(const Scalar* w, int stride, int columns, const Scalar* bias, const Scalar* in,
                                     int row, const Finish& finish) {
    using Rows = simd::Pack<Scalar, kTurned>;
    Rows sums[kRegisters][kColumns];
    for (int g = 0; g < kRegisters; ++g) {
      for (Rows& sum : sums[g]) sum = bias != nullptr ? simd::load<Rows>(bias + g * kTurned) : Rows{};
    }
    for (int c = 0; c < columns; ++c) {
      Rows weights[kRegisters];
      for (int g = 0; g < kRegisters; ++g) {
        weights[g] = simd::load<Rows>(w + c * stride + g * kTurned);
        simd::pin(weights[g]);
      }
      for (int s = 0; s < kColumns; ++s) {
        const Rows input = simd::broadcast<Rows>(in[c * kStride + s]);
        for (int g = 0; g < kRegisters; ++g) sums[g][s] += weights[g] * input;
      }
    }
    for (int g = 0; g < kRegisters; ++g)
      turn(sums[g], [&](int r, P sum) NLO_INLINE_LAMBDA { finish(row + g * kTurned + r, 0, sum); });
  }

  /// Transposes eight samples of sixteen rows to sixteen rows of eight samples: rows within 128 bits, then whole 128
  /// bits.
  template <class Rows, class Finish>
  static NLO_INLINE void turn(const Rows (&v)[kColumns], const Finish& finish) {
#define NLO_LANES(a, b, i, j, k, l)                                                                                 \
  __builtin_shufflevector(a, b, i, j, k, l, 4 + (i), 4 + (j), 4 + (k), 4 + (l), 8 + (i), 8 + (j), 8 + (k), 8 + (l), \
                          12 + (i), 12 + (j), 12 + (k), 12 + (l))
    Rows quads[2][4];  // row 4 q + r of samples 4 h to 4 h + 3 is in 128 bits q of quads[h][r]
    for (int h = 0; h < 2; ++h) {
      const Rows* of = v + 4 * h;
      const Rows low01 = NLO_LANES(of[0], of[1], 0, 16, 1, 17), low23 = NLO_LANES(of[2], of[3], 0, 16, 1, 17);
      const Rows high01 = NLO_LANES(of[0], of[1], 2, 18, 3, 19), high23 = NLO_LANES(of[2], of[3], 2, 18, 3, 19);
      quads[h][0] = NLO_LANES(low01, low23, 0, 1, 16, 17);
      quads[h][1] = NLO_LANES(low01, low23, 2, 3, 18, 19);
      quads[h][2] = NLO_LANES(high01, high23, 0, 1, 16, 17);
      quads[h][3] = NLO_LANES(high01, high23, 2, 3, 18, 19);
    }
#undef NLO_LANES
    for (int r = 0; r < 4; ++r) {
      const Rows a = quads[0][r], b = quads[1][r];
      finish(r, __builtin_shufflevector(a, b, 0, 1, 2, 3, 16, 17, 18, 19));
      finish(4 + r, __builtin_shufflevector(a, b, 4, 5, 6, 7, 20, 21, 22, 23));
      finish(8 + r, __builtin_shufflevector(a, b, 8, 9, 10, 11, 24, 25, 26, 27));
      finish(12 + r, __builtin_shufflevector(a, b, 12, 13, 14, 15, 28, 29, 30, 31));
    }
  }

  /// Each weight needs a sum over the samples of a block. In wide blocks each tile adds up its lanes, because a
  /// register of lanes per weight would not fit into the cache (500 kB for the paper's T*). Narrow blocks keep lanes:
  /// they run thousands of times per gradient, and their sums are too short.
  static constexpr bool kKeepsLanes = kColumns < 8 * kWidth;
  static constexpr int kLanesPerWeight = kKeepsLanes ? kWidth : 1;

  /// Adds sum_s dv[o][s] a[i][s] to the gradient of W[o][i], for kRows x kTile entries of W.
  template <int kRows, int kTile>
  static NLO_INLINE void outer_tile(const Scalar* dv, const Scalar* a, Scalar* gradient, int columns) {
    constexpr int kSlots = kKeepsLanes ? kTile : std::bit_ceil(unsigned{kTile});  // sums reserved for a row of W
    constexpr int kRegisters = (kRows * kSlots + kWidth - 1) / kWidth;
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
        for (int c = 0; c < kTile; ++c) sums[r * kSlots + c] += row * inputs[c];
      }
    }
    if constexpr (kKeepsLanes) {
      for (int i = 0; i < kRows * kTile; ++i) {
        Scalar* lanes = gradient + (i / kTile * columns + i % kTile) * kWidth;
        simd::store(lanes, simd::load<P>(lanes) + sums[i]);
      }
    } else {
      P totals[kRegisters];
      for (int g = 0; g < kRegisters; ++g) totals[g] = sum_of_lanes(sums + g * kWidth);
      const auto add_row = [&]<int kRow>(std::integral_constant<int, kRow>) NLO_INLINE_LAMBDA {
        constexpr int kFirst = kRow * kSlots % kWidth;
        add_lanes<kFirst, kTile>(totals[kRow * kSlots / kWidth], gradient + kRow * columns);
      };
      [&]<int... kRow>(std::integer_sequence<int, kRow...>) NLO_INLINE_LAMBDA {
        (add_row(std::integral_constant<int, kRow>()), ...);
      }
      (std::make_integer_sequence<int, kRows>());
    }
  }

  /// Adds lanes kFirst to kFirst + kCount - 1 to as many scalars of the gradient.
  template <int kFirst, int kCount>
  static NLO_INLINE void add_lanes(P totals, Scalar* gradient) {
    constexpr int kTogether = std::bit_floor(unsigned{kCount});
    if constexpr (kTogether == 1) {
      *gradient += totals[kFirst];
    } else {
      using Some = simd::Pack<Scalar, kTogether>;
      const Some some = [&]<int... kLane>(std::integer_sequence<int, kLane...>) NLO_INLINE_LAMBDA {
        return __builtin_shufflevector(totals, totals, (kFirst + kLane)...);
      }
      (std::make_integer_sequence<int, kTogether>());
      simd::store(gradient, simd::load<Some>(gradient) + some);
    }
    if constexpr (kCount > kTogether) add_lanes<kFirst + kTogether, kCount - kTogether>(totals, gradient + kTogether);
  }

  /// Returns a register whose lane i is the sum of the lanes of sums[i].
  static NLO_INLINE P sum_of_lanes(const P* sums) {
    P group[kWidth];
    for (int i = 0; i < kWidth; ++i) group[i] = sums[i];
    return lane_sums(group);
  }

  /// Computes the gradient of a product's weights, dv a^T.
  static void outer_product(const Scalar* dv, int rows, const Scalar* a, int columns, Scalar* gradient) {
    // Largest number of sums that fit into the registers after their lanes are added; with 32 registers these are
    // sixteen.
    constexpr int kMostColumns = kKeepsLanes ? 3 : kWidth >= 16 ? 4 : 2;
    in_even_parts<4>(rows, [&](auto row_count, int r) NLO_INLINE_LAMBDA {
      in_even_parts<kMostColumns>(columns, [&](auto column_count, int c) NLO_INLINE_LAMBDA {
        outer_tile<row_count(), column_count()>(dv + r * kStride, a + c * kStride,
                                                gradient + (r * columns + c) * kLanesPerWeight, columns);
      });
    });
  }

  /// Computes the gradient of a product's bias, the sum of each row.
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
        const P totals = sum_of_lanes(sums);
        for (int r = 0; r < count; ++r) gradient[first + r] += totals[r];
      }
    }
  }
};

}  // namespace nlo::trainer
