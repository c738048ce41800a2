// SPDX-License-Identifier: MIT
// A network within a latent system. The experiment gives its shape, the data gives the scales of its inputs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/structures/moments.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Returns the shape of fully connected layers. Throws codegen::Error if codegen/model/activations.h has no
/// `activation` of this name.
NetworkShape network_shape(int inputs, const std::vector<int>& hidden, int outputs, const std::string& activation,
                           bool linear_path);

/// Makes a network as [dynamics] describes it. It is not normalised yet.
DynamicsNetwork dynamics_network(const DynamicsConfig& config, int inputs, int outputs, bool linear_path);

/// The random stream of the initial weights of such a network. T* has stream 0 and T stream 2.
inline constexpr std::uint64_t kDynamicsStream = 1;

/// Adds all samples of a signal, n x samples, to moments [first, first + n).
void add_signal(const std::vector<float>& signal, int samples, std::size_t first, std::vector<Moments>& moments);

/// Returns the normalisation of a network's inputs from their moments.
Normalisation normalisation_by(const std::vector<Moments>& moments);

}  // namespace nlo::trainer
