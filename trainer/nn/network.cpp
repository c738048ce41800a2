// SPDX-License-Identifier: MIT
#include "trainer/nn/network.h"

#include <cmath>

#include "trainer/base/random.h"

namespace nlo::trainer {

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

std::vector<float> initial_parameters(const NetworkShape& shape, std::uint64_t seed, float last_scale,
                                      std::uint64_t stream) {
  std::vector<float> parameters(static_cast<std::size_t>(shape.parameters), 0.0F);
  RandomLanes random(stream_seed(seed, Purpose::kWeights, 0, stream));
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

}  // namespace nlo::trainer
