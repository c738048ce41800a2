// SPDX-License-Identifier: MIT
#include "trainer/nn/network_block.h"

#include <cmath>
#include <type_traits>

namespace nlo::trainer {

namespace {

/// tanh as it flies in float; in double, where gradients are compared with finite differences, the exact one: the
/// slope 1 - a^2 is that of tanh, not of its approximation.
template <class P>
NLO_INLINE P smooth_tanh(P v) {
  using Scalar = typename simd::ScalarOf<P>::Type;
  if constexpr (std::is_same_v<P, double>) {
    return std::tanh(v);
  } else if constexpr (std::is_same_v<Scalar, double>) {
    constexpr int kN = sizeof(P) / sizeof(double);
    for (int i = 0; i < kN; ++i) v[i] = std::tanh(v[i]);
    return v;
  } else {
    return tanh_rational(v);
  }
}

template <Activation kKind, class P>
NLO_INLINE P value_of(P v) {
  if constexpr (kKind == Activation::kTanh) {
    return smooth_tanh(v);
  } else if constexpr (kKind == Activation::kSilu) {
    const P half = v * simd::literal<P>(0.5);
    return half + half * smooth_tanh(half);
  } else {
    return activate<kKind>(v);
  }
}

/// s'(v), from v and a = s(v).
template <Activation kKind, class P>
NLO_INLINE P slope_of(P v, P a) {
  if constexpr (kKind == Activation::kSilu) {
    const P half = P{} + simd::literal<P>(0.5);
    const P s = half + half * smooth_tanh(v * half);
    return s + a * (P{} + simd::literal<P>(1.0) - s);
  } else {
    return activation_slope<kKind>(v, a);
  }
}

/// s''(v), from v and a = s(v).
template <Activation kKind, class P>
NLO_INLINE P curvature_of(P v, P a) {
  const P one = P{} + simd::literal<P>(1.0);
  const auto two = simd::literal<P>(2.0);
  if constexpr (kKind == Activation::kTanh) {
    return -two * a * (one - a * a);
  } else if constexpr (kKind == Activation::kRelu) {
    return P{};
  } else {  // s (1 - s) (2 + v (1 - 2 s)), s = sigmoid(v)
    const P half = P{} + simd::literal<P>(0.5);
    const P s = half + half * smooth_tanh(v * half);
    return s * (one - s) * (P{} + two + v * (one - two * s));
  }
}

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

  /// Adds sum_s dv[o][s] a[i][s] to the lanes of the gradient of W[o][i], for kRows x kTile entries of W.
  template <int kRows, int kTile>
  static NLO_INLINE void outer_tile(const Scalar* dv, const Scalar* a, Scalar* lanes, int columns) {
    P sums[kRows][kTile] = {};
    for (int s = 0; s < kColumns; s += kWidth) {
      P inputs[kTile];
      for (int c = 0; c < kTile; ++c) {
        inputs[c] = simd::load<P>(a + c * kStride + s);
        simd::pin(inputs[c]);
      }
      for (int r = 0; r < kRows; ++r) {
        P row = simd::load<P>(dv + r * kStride + s);
        simd::pin(row);
        for (int c = 0; c < kTile; ++c) sums[r][c] += row * inputs[c];
      }
    }
    for (int r = 0; r < kRows; ++r) {
      for (int c = 0; c < kTile; ++c) {
        Scalar* lane = lanes + (r * columns + c) * kWidth;
        simd::store(lane, simd::load<P>(lane) + sums[r][c]);
      }
    }
  }

  template <int kRows>
  static void outer_rows(const Scalar* dv, const Scalar* a, Scalar* lanes, int columns) {
    int c = 0;
    for (; c + 3 <= columns; c += 3) outer_tile<kRows, 3>(dv, a + c * kStride, lanes + c * kWidth, columns);
    if (columns - c == 2) outer_tile<kRows, 2>(dv, a + c * kStride, lanes + c * kWidth, columns);
    if (columns - c == 1) outer_tile<kRows, 1>(dv, a + c * kStride, lanes + c * kWidth, columns);
  }

  /// Gradient of a product's weights: lanes += dv a^T.
  static void outer_product(const Scalar* dv, int rows, const Scalar* a, int columns, Scalar* lanes) {
    int r = 0;
    for (; r + 4 <= rows; r += 4) outer_rows<4>(dv + r * kStride, a, lanes + r * columns * kWidth, columns);
    const Scalar* rest = dv + r * kStride;
    Scalar* rest_lanes = lanes + r * columns * kWidth;
    if (rows - r == 3) outer_rows<3>(rest, a, rest_lanes, columns);
    if (rows - r == 2) outer_rows<2>(rest, a, rest_lanes, columns);
    if (rows - r == 1) outer_rows<1>(rest, a, rest_lanes, columns);
  }
};

template <class Scalar>
std::vector<Scalar> rows(int count, int stride) {
  return std::vector<Scalar>(static_cast<std::size_t>(count) * static_cast<std::size_t>(stride), Scalar(0));
}

/// Calls run(std::integral_constant<Activation, kind>) for the kind at hand.
template <class Run>
void with_activation(Activation kind, const Run& run) {
  switch (kind) {
    case Activation::kTanh:
      return run(std::integral_constant<Activation, Activation::kTanh>{});
    case Activation::kRelu:
      return run(std::integral_constant<Activation, Activation::kRelu>{});
    case Activation::kSilu:
      return run(std::integral_constant<Activation, Activation::kSilu>{});
    case Activation::kTanh5e6:
    case Activation::kTanh5e5:
      break;  // what an export may choose; training has the best one
  }
}

}  // namespace

template <class Scalar, int kColumns>
NetworkBlock<Scalar, kColumns>::NetworkBlock(const NetworkShape& shape, bool with_tangents) : shape_(&shape) {
  int widest = shape.inputs();
  for (const LayerView& layer : shape.layers) widest = std::max(widest, layer.out);
  const auto make_room = [&](Pass& pass, bool keeps_pre_activations) {
    pass.activations.push_back(rows<Scalar>(shape.inputs(), kStride));
    for (const LayerView& layer : shape.layers) {
      pass.activations.push_back(rows<Scalar>(layer.out, kStride));
      if (keeps_pre_activations) pass.pre_activations.push_back(rows<Scalar>(layer.out, kStride));
    }
    for (auto& cotangent : pass.cotangent) cotangent = rows<Scalar>(widest, kStride);
    pass.input_cotangent = rows<Scalar>(shape.inputs(), kStride);
  };
  make_room(values_, shape.activation == Activation::kSilu);
  if (with_tangents) make_room(tangents_, true);
  lanes_.assign(static_cast<std::size_t>(shape.parameters) * kWidth, Scalar(0));
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::clear_gradient() {
  std::fill(lanes_.begin(), lanes_.end(), Scalar(0));
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::gradient(Scalar* out) const {
  using P = simd::Pack<Scalar, kWidth>;
  for (int i = 0; i < shape_->parameters; ++i) {
    out[i] = simd::sum<Scalar>(simd::load<P>(lanes_.data() + static_cast<std::ptrdiff_t>(i) * kWidth));
  }
}

template <class Scalar, int kColumns>
template <Activation kKind>
void NetworkBlock<Scalar, kColumns>::forward_as(const Scalar* parameters) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const std::size_t last = shape_->layers.size() - 1;
  for (std::size_t l = 0; l <= last; ++l) {
    const LayerView& layer = shape_->layers[l];
    Scalar* out = values_.activations[l + 1].data();
    const Scalar* in = values_.activations[l].data();
    Math::product(parameters + layer.weights, layer.out, layer.in, parameters + layer.bias, in,
                  [=](int row, int s, P v) NLO_INLINE_LAMBDA { simd::store(out + row * kStride + s, v); });
    if (l == last) break;
    // A pass of its own: inside the product's tiles GCC serialises the long dependency chain of a tanh.
    Scalar* pre = kKind == Activation::kSilu ? values_.pre_activations[l].data() : nullptr;
    for (int i = 0; i < layer.out * kStride; i += kWidth) {
      const P v = simd::load<P>(out + i);
      if constexpr (kKind == Activation::kSilu) simd::store(pre + i, v);
      simd::store(out + i, value_of<kKind>(v));
    }
  }
  if (shape_->linear_path >= 0) {
    Scalar* out = values_.activations.back().data();
    Math::product(parameters + shape_->linear_path, shape_->outputs(), shape_->inputs(), nullptr,
                  values_.activations[0].data(), [=](int row, int s, P v) NLO_INLINE_LAMBDA {
                    simd::store(out + row * kStride + s, simd::load<P>(out + row * kStride + s) + v);
                  });
  }
}

template <class Scalar, int kColumns>
template <Activation kKind>
void NetworkBlock<Scalar, kColumns>::forward_tangents_as(const Scalar* parameters) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const std::size_t last = shape_->layers.size() - 1;
  for (std::size_t l = 0; l <= last; ++l) {
    const LayerView& layer = shape_->layers[l];
    Scalar* out = tangents_.activations[l + 1].data();
    Math::product(parameters + layer.weights, layer.out, layer.in, nullptr, tangents_.activations[l].data(),
                  [=](int row, int s, P v) NLO_INLINE_LAMBDA { simd::store(out + row * kStride + s, v); });
    if (l == last) break;
    const Scalar* a = values_.activations[l + 1].data();
    const Scalar* v = kKind == Activation::kSilu ? values_.pre_activations[l].data() : a;
    Scalar* pre = tangents_.pre_activations[l].data();
    for (int i = 0; i < layer.out * kStride; i += kWidth) {
      const P tangent = simd::load<P>(out + i);
      simd::store(pre + i, tangent);
      // relu: a > 0 exactly where v > 0
      simd::store(out + i, tangent * slope_of<kKind>(simd::load<P>(v + i), simd::load<P>(a + i)));
    }
  }
  if (shape_->linear_path >= 0) {
    Scalar* out = tangents_.activations.back().data();
    Math::product(parameters + shape_->linear_path, shape_->outputs(), shape_->inputs(), nullptr,
                  tangents_.activations[0].data(), [=](int row, int s, P v) NLO_INLINE_LAMBDA {
                    simd::store(out + row * kStride + s, simd::load<P>(out + row * kStride + s) + v);
                  });
  }
}

/// Gradient and input cotangent through the linear path; L is small, and read by columns here.
template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::path_backward(const Scalar* parameters, Pass& pass) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const Scalar* cotangent = pass.last_cotangent();
  const int inputs = shape_->inputs();
  Math::outer_product(cotangent, shape_->outputs(), pass.activations[0].data(), inputs,
                      lanes_.data() + static_cast<std::ptrdiff_t>(shape_->linear_path) * kWidth);
  const Scalar* path = parameters + shape_->linear_path;
  for (int i = 0; i < inputs; ++i) {
    for (int s = 0; s < kColumns; s += kWidth) {
      P sum{};
      for (int o = 0; o < shape_->outputs(); ++o) {
        sum += simd::broadcast<P>(path[o * inputs + i]) * simd::load<P>(cotangent + o * kStride + s);
      }
      simd::store(pass.input_cotangent.data() + i * kStride + s, sum);
    }
  }
}

template <class Scalar, int kColumns>
template <Activation kKind, bool kTangents>
void NetworkBlock<Scalar, kColumns>::backward_as(const Scalar* parameters, const Scalar* transposed) {
  using Math = Products<Scalar, kColumns>;
  using P = typename Math::P;
  const bool has_path = shape_->linear_path >= 0;
  if (has_path) {
    path_backward(parameters, values_);
    if constexpr (kTangents) path_backward(parameters, tangents_);
  }
  for (std::size_t l = shape_->layers.size(); l-- > 0;) {
    const LayerView& layer = shape_->layers[l];
    const Scalar* dv = values_.cotangent[(l + 1) % 2].data();
    const Scalar* in = values_.activations[l].data();
    Scalar* lanes = lanes_.data() + static_cast<std::ptrdiff_t>(layer.weights) * kWidth;
    Math::outer_product(dv, layer.out, in, layer.in, lanes);
    for (int o = 0; o < layer.out; ++o) {
      P sum{};
      for (int s = 0; s < kColumns; s += kWidth) sum += simd::load<P>(dv + o * kStride + s);
      Scalar* lane = lanes_.data() + static_cast<std::ptrdiff_t>(layer.bias + o) * kWidth;
      simd::store(lane, simd::load<P>(lane) + sum);
    }
    const Scalar* dv_tangent = nullptr;
    if constexpr (kTangents) {
      dv_tangent = tangents_.cotangent[(l + 1) % 2].data();
      Math::outer_product(dv_tangent, layer.out, tangents_.activations[l].data(), layer.in, lanes);
    }
    if (l == 0) {
      const auto to_inputs = [&](const Scalar* cotangent, Scalar* out) {
        Math::product(transposed + layer.weights, layer.in, layer.out, nullptr, cotangent,
                      [=](int row, int s, P v) NLO_INLINE_LAMBDA {
                        simd::store(out + row * kStride + s, has_path ? simd::load<P>(out + row * kStride + s) + v : v);
                      });
      };
      to_inputs(dv, values_.input_cotangent.data());
      if constexpr (kTangents) to_inputs(dv_tangent, tangents_.input_cotangent.data());
      return;
    }
    Scalar* out = values_.cotangent[l % 2].data();
    const Scalar* pre = kKind == Activation::kSilu ? values_.pre_activations[l - 1].data() : in;
    if constexpr (kTangents) {
      Scalar* out_tangent = tangents_.cotangent[l % 2].data();
      const Scalar* pre_tangent = tangents_.pre_activations[l - 1].data();
      Math::product(transposed + layer.weights, layer.in, layer.out, nullptr, dv_tangent,
                    [=](int row, int s, P v) NLO_INLINE_LAMBDA { simd::store(out_tangent + row * kStride + s, v); });
      Math::product(
          transposed + layer.weights, layer.in, layer.out, nullptr, dv, [=](int row, int s, P value) NLO_INLINE_LAMBDA {
            const int at = row * kStride + s;
            const P v = simd::load<P>(pre + at), a = simd::load<P>(in + at);
            const P tangent = simd::load<P>(out_tangent + at), slope = slope_of<kKind>(v, a);
            simd::store(out + at,
                        slope * value + curvature_of<kKind>(v, a) * simd::load<P>(pre_tangent + at) * tangent);
            simd::store(out_tangent + at, slope * tangent);
          });
    } else {
      Math::product(
          transposed + layer.weights, layer.in, layer.out, nullptr, dv, [=](int row, int s, P v) NLO_INLINE_LAMBDA {
            const P slope =
                slope_of<kKind>(simd::load<P>(pre + row * kStride + s), simd::load<P>(in + row * kStride + s));
            simd::store(out + row * kStride + s, v * slope);
          });
    }
  }
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::forward(const Scalar* parameters) {
  with_activation(shape_->activation, [&](auto kind) { forward_as<kind()>(parameters); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::forward_tangents(const Scalar* parameters) {
  with_activation(shape_->activation, [&](auto kind) { forward_tangents_as<kind()>(parameters); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::backward(const Scalar* parameters, const Scalar* transposed) {
  with_activation(shape_->activation, [&](auto kind) { backward_as<kind(), false>(parameters, transposed); });
}

template <class Scalar, int kColumns>
void NetworkBlock<Scalar, kColumns>::backward_tangents(const Scalar* parameters, const Scalar* transposed) {
  with_activation(shape_->activation, [&](auto kind) { backward_as<kind(), true>(parameters, transposed); });
}

template class NetworkBlock<float, kBlock>;
template class NetworkBlock<float, 8>;
template class NetworkBlock<double, 8>;

}  // namespace nlo::trainer
