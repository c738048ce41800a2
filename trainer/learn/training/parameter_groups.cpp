// SPDX-License-Identifier: MIT
#include "trainer/learn/training/parameter_groups.h"

#include "trainer/structures/structure.h"

namespace nlo::trainer {

std::vector<ParameterGroup> parameter_groups(const Experiment& experiment, const ObserverStructure& structure) {
  const TrainingConfig& config = experiment.training;
  const double eigenvalue_rate =
      config.eigenvalue_learning_rate > 0.0 ? config.eigenvalue_learning_rate : config.learning_rate;
  std::vector<ParameterGroup> groups;
  const auto add_network = [&](const NetworkShape& network, double path_rate) {
    for (const LayerView& layer : network.layers) {
      groups.push_back({layer.in * layer.out, config.learning_rate, config.weight_decay});
      groups.push_back({layer.out, config.learning_rate, 0.0});
    }
    if (network.linear_path >= 0) groups.push_back({network.inputs() * network.outputs(), path_rate, 0.0});
  };
  if (structure.latent.learned > 0)
    groups.push_back({structure.latent.learned, experiment.observer.learn_eigenvalues ? eigenvalue_rate : 0.0, 0.0});
  add_network(structure.dynamics.shape, eigenvalue_rate);
  // If the features do not change, the linear path keeps its ridge regression. First-order steps on nearly collinear
  // features would make it worse (alpha_dot on the Qube: .073 -> .118 rad/s).
  const bool fixed_features = !latent_system_learns(experiment, structure);
  add_network(structure.network, fixed_features ? 0.0 : config.learning_rate);
  if (structure.forward_map) add_network(*structure.forward_map, 0.0);
  return groups;
}

}  // namespace nlo::trainer
