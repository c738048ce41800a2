// SPDX-License-Identifier: MIT
// A network within a latent system: its shape from the config, the scales of its inputs from the data.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/structures/moments.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Fully connected layers; `activation` is a name in the table of codegen/model/activations.h, else codegen::Error.
NetworkShape network_shape(int inputs, const std::vector<int>& hidden, int outputs, const std::string& activation,
                           bool linear_path);

/// By [dynamics]; not normalised yet.
DynamicsNetwork dynamics_network(const DynamicsConfig& config, int inputs, int outputs, bool linear_path);

/// Stream of the random numbers that such a network starts from; T* has stream 0 and T stream 2.
inline constexpr std::uint64_t kDynamicsStream = 1;

/// Adds every sample of a signal, n x samples, to moments [first, first + n).
void add_signal(const std::vector<float>& signal, int samples, std::size_t first, std::vector<Moments>& moments);

/// Normalisation of a network's inputs by their moments.
Normalisation normalisation_by(const std::vector<Moments>& moments);

}  // namespace nlo::trainer
