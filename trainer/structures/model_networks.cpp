// SPDX-License-Identifier: MIT
#include "trainer/structures/model_networks.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd to_double(const std::vector<float>& values) {
  return Eigen::Map<const Eigen::VectorXf>(values.data(), static_cast<Index>(values.size())).cast<double>();
}

/// Returns a network with its layers and its linear path. The caller sets features and scales.
codegen::Network network_of(const NetworkShape& shape, const float* parameters) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  codegen::Network network;
  network.activation = shape.activation;
  for (const LayerView& layer : shape.layers) {
    network.layers.push_back(
        {Eigen::Map<const RowMajor>(parameters + layer.weights, layer.out, layer.in).cast<double>(),
         Eigen::Map<const Eigen::VectorXf>(parameters + layer.bias, layer.out).cast<double>()});
  }
  if (shape.linear_path >= 0) {
    network.skip =
        Eigen::Map<const RowMajor>(parameters + shape.linear_path, shape.outputs(), shape.inputs()).cast<double>();
  }
  return network;
}

}  // namespace

codegen::Network dynamics_of(const DynamicsNetwork& dynamics, const float* parameters) {
  const auto inputs = static_cast<Index>(dynamics.inputs.mean.size());
  codegen::Network network = network_of(dynamics.shape, parameters);
  network.features = MatrixXd::Identity(inputs, inputs);
  network.feature_mean = Eigen::Map<const VectorXd>(dynamics.inputs.mean.data(), inputs);
  network.feature_scale = Eigen::Map<const VectorXd>(dynamics.inputs.scale.data(), inputs);
  network.output_mean = VectorXd::Zero(dynamics.shape.outputs());
  network.output_scale = VectorXd::Ones(dynamics.shape.outputs());
  return network;
}

codegen::Network rows_of(const codegen::Network& all, Index first, Index count) {
  codegen::Network part = all;
  part.layers[0].weights = all.layers[0].weights.middleRows(first, count);
  part.layers[0].bias = all.layers[0].bias.segment(first, count);
  part.output_mean = all.output_mean.segment(first, count);
  part.output_scale = all.output_scale.segment(first, count);
  return part;
}

codegen::Network inverse_map_of(const ObserverStructure& structure, const float* parameters, Index readings) {
  const auto nf = static_cast<Index>(structure.features.size());
  const Index nz = structure.latent.rows;
  codegen::Network map = network_of(structure.network, parameters + structure.dynamics_parameters());
  map.features = MatrixXd::Zero(nf, nz + readings);
  map.feature_mean.resize(nf);
  map.feature_scale.resize(nf);
  for (Index f = 0; f < nf; ++f) {
    const Feature& feature = structure.features[static_cast<std::size_t>(f)];
    if (feature.latent >= 0) map.features(f, feature.latent) = 1.0;
    if (feature.reading >= 0) map.features(f, nz + feature.reading) = static_cast<double>(feature.reading_gain);
    map.feature_mean(f) = static_cast<double>(feature.mean);
    map.feature_scale(f) = static_cast<double>(feature.scale);
    if (feature.clock >= 0) {
      map.feature_clocks.resize(structure.features.size(), -1);
      map.feature_clocks[static_cast<std::size_t>(f)] = feature.clock;
    }
  }
  map.output_mean = to_double(structure.state_mean);
  map.output_scale = to_double(structure.state_scale);
  return map;
}

codegen::Network forward_map_of(const ObserverStructure& structure, const float* parameters) {
  const auto nx = static_cast<Index>(structure.state_mean.size());
  const float* own = parameters + structure.dynamics_parameters() + structure.network.parameters;
  codegen::Network map = network_of(*structure.forward_map, own);
  map.features = MatrixXd::Identity(nx, nx);
  map.feature_mean = to_double(structure.state_mean);
  map.feature_scale = to_double(structure.state_scale);
  map.output_mean = to_double(structure.latent_mean);
  map.output_scale = to_double(structure.latent_scale);
  return map;
}

}  // namespace nlo::trainer
