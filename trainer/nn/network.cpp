// SPDX-License-Identifier: MIT
#include "trainer/nn/network.h"

#include <algorithm>
#include <cmath>

#include "nlo/simd.h"
#include "trainer/random.h"

namespace nlo::trainer {

using P = simd::Pack<float>;
constexpr int kWidth = simd::kLanes<float>;
constexpr int kPacks = 2;  // registers of samples a tile is wide
static_assert(kBlock % (kPacks * kWidth) == 0);

NetworkShape NetworkShape::make(const std::vector<int>& widths, Activation activation, bool linear_path) {
  NetworkShape shape;
  shape.activation = activation;
  int offset = 0;
  for (std::size_t l = 1; l < widths.size(); ++l) {
    const LayerView layer{widths[l - 1], widths[l], offset, offset + widths[l - 1] * widths[l]};
    offset = layer.bias + layer.out;
    shape.layers.push_back(layer);
  }
  if (linear_path) {
    shape.linear_path = offset;
    offset += widths.front() * widths.back();
  }
  shape.parameters = offset;
  return shape;
}

std::vector<float> initial_parameters(const NetworkShape& shape, std::uint64_t seed, float last_scale) {
  std::vector<float> parameters(static_cast<std::size_t>(shape.parameters), 0.0F);
  RandomLanes random(stream_seed(seed, Purpose::kWeights, 0, 0));
  RandomLanes::Floats uniform{};
  int lane = RandomLanes::kLanes;
  for (const LayerView& layer : shape.layers) {
    const auto fan_in = static_cast<float>(layer.in);
    const auto fan_out = static_cast<float>(layer.out);
    float bound =
        shape.activation == Activation::kTanh ? std::sqrt(6.0F / (fan_in + fan_out)) : std::sqrt(6.0F / fan_in);
    if (&layer == &shape.layers.back()) bound *= last_scale;
    for (int i = 0; i < layer.in * layer.out; ++i) {
      if (lane == RandomLanes::kLanes) {
        random.uniform(uniform.data());
        lane = 0;
      }
      parameters[static_cast<std::size_t>(layer.weights + i)] =
          bound * (2.0F * uniform[static_cast<std::size_t>(lane++)] - 1.0F);
    }
  }
  return parameters;
}

long multiply_adds(const NetworkShape& shape) {
  long total = shape.linear_path >= 0 ? static_cast<long>(shape.inputs()) * shape.outputs() : 0;
  for (const LayerView& layer : shape.layers) total += static_cast<long>(layer.in) * layer.out;
  return total;
}

namespace {

/// One tile: kRows rows of W times kPacks registers of samples. `finish(row, pack, sum)` takes each result.
template <int kRows, class Finish>
NLO_INLINE void product_tile(const float* w, int columns, const float* bias, const float* in, const Finish& finish) {
  P sums[kRows][kPacks];
  for (int r = 0; r < kRows; ++r) {
    for (P& sum : sums[r]) sum = simd::broadcast<P>(bias != nullptr ? bias[r] : 0.0F);
  }
  for (int c = 0; c < columns; ++c) {
    P inputs[kPacks];
    for (int p = 0; p < kPacks; ++p) {
      inputs[p] = simd::load<P>(in + c * kRow + p * kWidth);
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

/// out = finish(W in + bias) over a block: `rows` x `columns` times `columns` x kBlock.
/// Rows are shared out evenly over tiles of at most six: 12 sums, the inputs and a weight fill 16 registers.
template <class Finish>
void product(const float* w, int rows, int columns, const float* bias, const float* in, const Finish& finish) {
  constexpr int kMaxRows = 6;
  const int tiles = (rows + kMaxRows - 1) / kMaxRows;
  for (int s = 0; s < kBlock; s += kPacks * kWidth) {
    int row = 0;
    for (int t = 0; t < tiles; ++t) {
      const int take = (rows - row) / (tiles - t) + ((rows - row) % (tiles - t) != 0 ? 1 : 0);
      const float* tile_w = w + row * columns;
      const float* tile_bias = bias != nullptr ? bias + row : nullptr;
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

/// Adds sum_s dv[o][s] a[i][s] to the lanes of the gradient of W[o][i], for kRows x kColumns entries of W.
template <int kRows, int kColumns>
NLO_INLINE void outer_tile(const float* dv, const float* a, float* lanes, int columns) {
  P sums[kRows][kColumns] = {};
  for (int s = 0; s < kBlock; s += kWidth) {
    P inputs[kColumns];
    for (int c = 0; c < kColumns; ++c) {
      inputs[c] = simd::load<P>(a + c * kRow + s);
      simd::pin(inputs[c]);
    }
    for (int r = 0; r < kRows; ++r) {
      P row = simd::load<P>(dv + r * kRow + s);
      simd::pin(row);
      for (int c = 0; c < kColumns; ++c) sums[r][c] += row * inputs[c];
    }
  }
  for (int r = 0; r < kRows; ++r) {
    for (int c = 0; c < kColumns; ++c) {
      float* lane = lanes + (r * columns + c) * kWidth;
      simd::store(lane, simd::load<P>(lane) + sums[r][c]);
    }
  }
}

template <int kRows>
void outer_rows(const float* dv, const float* a, float* lanes, int columns) {
  int c = 0;
  for (; c + 3 <= columns; c += 3) outer_tile<kRows, 3>(dv, a + c * kRow, lanes + c * kWidth, columns);
  if (columns - c == 2) outer_tile<kRows, 2>(dv, a + c * kRow, lanes + c * kWidth, columns);
  if (columns - c == 1) outer_tile<kRows, 1>(dv, a + c * kRow, lanes + c * kWidth, columns);
}

/// Gradient of a product's weights: lanes += dv a^T.
void outer_product(const float* dv, int rows, const float* a, int columns, float* lanes) {
  int r = 0;
  for (; r + 4 <= rows; r += 4) outer_rows<4>(dv + r * kRow, a, lanes + r * columns * kWidth, columns);
  const float* rest = dv + r * kRow;
  float* rest_lanes = lanes + r * columns * kWidth;
  if (rows - r == 3) outer_rows<3>(rest, a, rest_lanes, columns);
  if (rows - r == 2) outer_rows<2>(rest, a, rest_lanes, columns);
  if (rows - r == 1) outer_rows<1>(rest, a, rest_lanes, columns);
}

std::vector<float> rows(int count) {
  return std::vector<float>(static_cast<std::size_t>(count) * kRow, 0.0F);
}

}  // namespace

BlockWorkspace::BlockWorkspace(const NetworkShape& shape) : shape_(&shape) {
  int widest = shape.inputs();
  activations_.push_back(rows(shape.inputs()));
  for (const LayerView& layer : shape.layers) {
    activations_.push_back(rows(layer.out));
    if (shape.activation == Activation::kSilu) pre_activations_.push_back(rows(layer.out));
    widest = std::max(widest, layer.out);
  }
  for (auto& cotangent : cotangent_) cotangent = rows(widest);
  input_cotangent_ = rows(shape.inputs());
  lanes_.assign(static_cast<std::size_t>(shape.parameters) * kWidth, 0.0F);
}

void BlockWorkspace::clear_gradient() {
  std::fill(lanes_.begin(), lanes_.end(), 0.0F);
}

void BlockWorkspace::gradient(float* out) const {
  for (int i = 0; i < shape_->parameters; ++i) {
    out[i] = simd::sum<float>(simd::load<P>(lanes_.data() + static_cast<std::ptrdiff_t>(i) * kWidth));
  }
}

template <Activation kKind>
void BlockWorkspace::forward_as(const float* parameters) {
  const std::size_t last = shape_->layers.size() - 1;
  for (std::size_t l = 0; l <= last; ++l) {
    const LayerView& layer = shape_->layers[l];
    float* out = activations_[l + 1].data();
    const float* in = activations_[l].data();
    product(parameters + layer.weights, layer.out, layer.in, parameters + layer.bias, in,
            [=](int row, int s, P v) NLO_INLINE_LAMBDA { simd::store(out + row * kRow + s, v); });
    if (l == last) break;
    // A pass of its own: inside the product's tiles GCC serialises the long dependency chain of a tanh.
    float* pre = kKind == Activation::kSilu ? pre_activations_[l].data() : nullptr;
    for (int i = 0; i < layer.out * kRow; i += kWidth) {
      const P v = simd::load<P>(out + i);
      if constexpr (kKind == Activation::kSilu) simd::store(pre + i, v);
      simd::store(out + i, activate<kKind>(v));
    }
  }
  if (shape_->linear_path >= 0) {
    float* out = activations_.back().data();
    product(parameters + shape_->linear_path, shape_->outputs(), shape_->inputs(), nullptr, activations_[0].data(),
            [=](int row, int s, P v)
                NLO_INLINE_LAMBDA { simd::store(out + row * kRow + s, simd::load<P>(out + row * kRow + s) + v); });
  }
}

template <Activation kKind>
void BlockWorkspace::backward_as(const float* parameters, const float* transposed) {
  const bool has_path = shape_->linear_path >= 0;
  if (has_path) {
    outer_product(output_cotangent(), shape_->outputs(), activations_[0].data(), shape_->inputs(),
                  lanes_.data() + static_cast<std::ptrdiff_t>(shape_->linear_path) * kWidth);
    // dL/du through the linear path: L is small, and read by columns here.
    const float* path = parameters + shape_->linear_path;
    const int inputs = shape_->inputs();
    for (int i = 0; i < inputs; ++i) {
      for (int s = 0; s < kBlock; s += kWidth) {
        P sum{};
        for (int o = 0; o < shape_->outputs(); ++o) {
          sum += simd::broadcast<P>(path[o * inputs + i]) * simd::load<P>(output_cotangent() + o * kRow + s);
        }
        simd::store(input_cotangent_.data() + i * kRow + s, sum);
      }
    }
  }
  for (std::size_t l = shape_->layers.size(); l-- > 0;) {
    const LayerView& layer = shape_->layers[l];
    const float* dv = cotangent_[(l + 1) % 2].data();
    const float* in = activations_[l].data();
    outer_product(dv, layer.out, in, layer.in, lanes_.data() + static_cast<std::ptrdiff_t>(layer.weights) * kWidth);
    for (int o = 0; o < layer.out; ++o) {
      P sum{};
      for (int s = 0; s < kBlock; s += kWidth) sum += simd::load<P>(dv + o * kRow + s);
      float* lane = lanes_.data() + static_cast<std::ptrdiff_t>(layer.bias + o) * kWidth;
      simd::store(lane, simd::load<P>(lane) + sum);
    }
    if (l > 0) {
      float* out = cotangent_[l % 2].data();
      const float* pre = kKind == Activation::kSilu ? pre_activations_[l - 1].data() : in;
      product(transposed + layer.weights, layer.in, layer.out, nullptr, dv, [=](int row, int s, P v) NLO_INLINE_LAMBDA {
        const P slope =
            activation_slope<kKind>(simd::load<P>(pre + row * kRow + s), simd::load<P>(in + row * kRow + s));
        simd::store(out + row * kRow + s, v * slope);
      });
    } else {
      float* out = input_cotangent_.data();
      product(transposed + layer.weights, layer.in, layer.out, nullptr, dv, [=](int row, int s, P v) NLO_INLINE_LAMBDA {
        simd::store(out + row * kRow + s, has_path ? simd::load<P>(out + row * kRow + s) + v : v);
      });
    }
  }
}

void BlockWorkspace::forward(const float* parameters) {
  switch (shape_->activation) {
    case Activation::kTanh:
      return forward_as<Activation::kTanh>(parameters);
    case Activation::kRelu:
      return forward_as<Activation::kRelu>(parameters);
    case Activation::kSilu:
      return forward_as<Activation::kSilu>(parameters);
  }
}

void BlockWorkspace::backward(const float* parameters, const float* transposed) {
  switch (shape_->activation) {
    case Activation::kTanh:
      return backward_as<Activation::kTanh>(parameters, transposed);
    case Activation::kRelu:
      return backward_as<Activation::kRelu>(parameters, transposed);
    case Activation::kSilu:
      return backward_as<Activation::kSilu>(parameters, transposed);
  }
}

void transpose_weights(const NetworkShape& shape, const float* parameters, float* transposed) {
  for (const LayerView& layer : shape.layers) {
    for (int o = 0; o < layer.out; ++o) {
      for (int i = 0; i < layer.in; ++i) {
        transposed[layer.weights + i * layer.out + o] = parameters[layer.weights + o * layer.in + i];
      }
    }
  }
}

}  // namespace nlo::trainer
