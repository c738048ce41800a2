// SPDX-License-Identifier: MIT
// The networks of a trained observer as a model holds them: in double, with the normalisation that training gave them.
#pragma once

#include "codegen/model/network.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// The network within the latent system: u = (in - mean) / scale, outputs in their own units.
codegen::Network dynamics_of(const DynamicsNetwork& dynamics, const float* parameters);

/// Outputs [first, first + count) of a network of one layer.
codegen::Network rows_of(const codegen::Network& all, Eigen::Index first, Eigen::Index count);

/// T* or G of `structure`, from all its parameters.
///   outputs  how many of y it reads beside z: n_y or 0
codegen::Network inverse_map_of(const ObserverStructure& structure, const float* parameters, Eigen::Index outputs);

/// T of `structure`, from all its parameters.
codegen::Network forward_map_of(const ObserverStructure& structure, const float* parameters);

}  // namespace nlo::trainer
