// SPDX-License-Identifier: MIT
// A network as a shape over a flat parameter vector; network_block.h runs it.
//   a_0 = u,  v_l = W_l a_{l-1} + b_l,  a_l = activation(v_l) for all but the last layer,  n = v_last + L u
#pragma once

#include <cstdint>
#include <vector>

#include "nlo/kernels/activation.h"

namespace nlo::trainer {

/// The place of one layer's parameters in the flat vector: W row by row (n_out x n_in), then b (n_out).
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

/// Draws weights uniformly within the bound of Glorot or He; codegen/model/activations.h has the bound of each
/// activation. Biases and L are zero. last_scale shrinks the last layer: 0 starts from the linear path alone. `stream`
/// differs between the networks of one observer.
std::vector<float> initial_parameters(const NetworkShape& shape, std::uint64_t seed, float last_scale,
                                      std::uint64_t stream = 0);

/// Returns the multiply-adds of one forward sample. Backward takes twice that, less the input gradient of the first
/// layer.
long multiply_adds(const NetworkShape& shape);

/// Returns W_l^T of every layer, each at the offset of W_l.
template <class Scalar>
void transpose_weights(const NetworkShape& shape, const Scalar* parameters, Scalar* transposed) {
  for (const LayerView& layer : shape.layers) {
    for (int o = 0; o < layer.out; ++o) {
      for (int i = 0; i < layer.in; ++i) {
        transposed[layer.weights + i * layer.out + o] = parameters[layer.weights + o * layer.in + i];
      }
    }
  }
}

}  // namespace nlo::trainer
