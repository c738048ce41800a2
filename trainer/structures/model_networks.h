// SPDX-License-Identifier: MIT
// Converts the networks of a trained observer into those of a model: in double, with the normalisation of the training.
#pragma once

#include "codegen/model/network.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Returns the network within the latent system: u = (in - mean) / scale, outputs in their own units.
codegen::Network dynamics_of(const DynamicsNetwork& dynamics, const float* parameters);

/// Returns outputs [first, first + count) of a network of one layer.
codegen::Network rows_of(const codegen::Network& all, Eigen::Index first, Eigen::Index count);

/// Returns T* or G of `structure` from all its parameters.
///   outputs  number of outputs that it reads beside z: n_y or 0
codegen::Network inverse_map_of(const ObserverStructure& structure, const float* parameters, Eigen::Index outputs);

/// Returns T of `structure` from all its parameters.
codegen::Network forward_map_of(const ObserverStructure& structure, const float* parameters);

}  // namespace nlo::trainer
