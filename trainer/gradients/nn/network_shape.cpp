// SPDX-License-Identifier: MIT
#include "trainer/gradients/nn/network_shape.h"

#include <cmath>

#include "codegen/model/activations.h"
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

namespace {

float weight_bound(Activation activation, float fan_in, float fan_out) {
  switch (codegen::activation_row(activation).weight_bound) {
    case codegen::WeightBound::kGlorot:
      return std::sqrt(6.0F / (fan_in + fan_out));
    case codegen::WeightBound::kHe:
      return std::sqrt(6.0F / fan_in);
  }
  throw codegen::Error(
      "this activation has no bound for initial weights; add one to its row in codegen/model/activations.h");
}

}  // namespace

std::vector<float> initial_parameters(const NetworkShape& shape, std::uint64_t seed, float last_scale,
                                      std::uint64_t stream) {
  std::vector<float> parameters(static_cast<std::size_t>(shape.parameters), 0.0F);
  RandomLanes random(stream_seed(seed, Purpose::kWeights, 0, stream));
  RandomLanes::Floats uniform{};
  int lane = RandomLanes::kLanes;
  for (const LayerView& layer : shape.layers) {
    const auto fan_in = static_cast<float>(layer.in);
    const auto fan_out = static_cast<float>(layer.out);
    float bound = weight_bound(shape.activation, fan_in, fan_out);
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
