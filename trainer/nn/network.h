// SPDX-License-Identifier: MIT
// The network of T* as a shape over a flat parameter vector, and its batched forward and backward passes.
//   a_0 = u,  v_l = W_l a_{l-1} + b_l,  a_l = activation(v_l) for all but the last layer,  n = v_last + L u
// Samples are processed in blocks that stay in cache through forward and backward; within a block a row holds one
// neuron for all samples, so every operation runs along the samples in whole SIMD registers.
#pragma once

#include <cstdint>
#include <vector>

#include "nlo/activation.h"

namespace nlo::trainer {

/// Where one layer's parameters lie in the flat vector: W row by row (n_out x n_in), then b (n_out).
struct LayerView {
  int in = 0, out = 0;
  int weights = 0, bias = 0;
};

struct NetworkShape {
  Activation activation = Activation::kTanh;
  std::vector<LayerView> layers;
  int linear_path = -1;  ///< offset of L (n_out x n_in, row by row); -1: none
  int parameters = 0;

  int inputs() const { return layers.front().in; }
  int outputs() const { return layers.back().out; }

  /// widths: inputs, hidden widths..., outputs.
  static NetworkShape make(const std::vector<int>& widths, Activation activation, bool linear_path);
};

/// Glorot's uniform initialisation for tanh, He's for relu and silu; biases zero, L zero.
/// last_scale shrinks the last layer: 0 starts from the linear path alone.
std::vector<float> initial_parameters(const NetworkShape& shape, std::uint64_t seed, float last_scale);

/// Multiply-adds of one sample, forward; backward costs twice that, less the first layer's input gradient.
long multiply_adds(const NetworkShape& shape);

/// Samples in a block, and the distance between rows: no power of two, so that rows spread over the cache's sets.
inline constexpr int kBlock = 256;
inline constexpr int kRow = kBlock + 16;

/// What one thread needs for a block, and the gradient it accumulates.
class BlockWorkspace {
 public:
  explicit BlockWorkspace(const NetworkShape& shape);

  /// Input features u, n_in rows; to be filled by the caller. Columns past the samples must be finite.
  float* input() { return activations_[0].data(); }
  /// Network output n, n_out rows.
  float* output() { return activations_.back().data(); }
  /// Cotangent of the output, n_out rows; to be filled by the caller, zero past the samples. Overwritten by backward().
  float* output_cotangent() { return cotangent_[(activations_.size() - 1) % 2].data(); }
  /// Cotangent of the input, n_in rows, after backward().
  const float* input_cotangent() const { return input_cotangent_.data(); }

  void forward(const float* parameters);
  /// Adds to the gradient. `transposed` is made once per step by transpose_weights().
  void backward(const float* parameters, const float* transposed);

  void clear_gradient();
  /// Writes the gradient (n parameters).
  void gradient(float* out) const;

 private:
  template <Activation kKind>
  void forward_as(const float* parameters);
  template <Activation kKind>
  void backward_as(const float* parameters, const float* transposed);

  const NetworkShape* shape_;
  std::vector<std::vector<float>> activations_;      // a_0 ... a_L, (width x kRow) each
  std::vector<std::vector<float>> pre_activations_;  // v_l, only where the slope needs it (silu)
  std::vector<float> cotangent_[2];
  std::vector<float> input_cotangent_;
  std::vector<float> lanes_;  // gradient, one SIMD register per parameter: summed over lanes only at the end
};

/// W_l^T of every layer, each at the offset of W_l.
void transpose_weights(const NetworkShape& shape, const float* parameters, float* transposed);

}  // namespace nlo::trainer
