// SPDX-License-Identifier: MIT
#include "trainer/structures/dynamics_network.h"

#include "codegen/model/activations.h"

namespace nlo::trainer {

NetworkShape network_shape(int inputs, const std::vector<int>& hidden, int outputs, const std::string& activation,
                           bool linear_path) {
  std::vector<int> widths{inputs};
  widths.insert(widths.end(), hidden.begin(), hidden.end());
  widths.push_back(outputs);
  return NetworkShape::make(widths, codegen::activation_named(activation).kind, linear_path);
}

DynamicsNetwork dynamics_network(const DynamicsConfig& config, int inputs, int outputs, bool linear_path) {
  const auto count = static_cast<std::size_t>(inputs);
  return {network_shape(inputs, config.hidden, outputs, config.activation, linear_path),
          {std::vector<double>(count, 0.0), std::vector<double>(count, 1.0)}};
}

void add_signal(const std::vector<float>& signal, int samples, std::size_t first, std::vector<Moments>& moments) {
  for (std::size_t row = 0; row + first < moments.size(); ++row)
    for (int k = 0; k < samples; ++k)
      moments[first + row].add(
          static_cast<double>(signal[row * static_cast<std::size_t>(samples) + static_cast<std::size_t>(k)]), 1.0);
}

Normalisation normalisation_by(const std::vector<Moments>& moments) {
  Normalisation result;
  for (const Moments& input : moments) {
    result.mean.push_back(input.mean);
    result.scale.push_back(static_cast<double>(safe_scale(input.deviation())));
  }
  return result;
}

}  // namespace nlo::trainer
