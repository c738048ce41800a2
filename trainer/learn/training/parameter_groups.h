// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/learn/optim/optimiser.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Returns the rate and the decay of each range of parameters in their order: eigenvalues, network of the latent
/// system, T*, T.
std::vector<ParameterGroup> parameter_groups(const Experiment& experiment, const ObserverStructure& structure);

}  // namespace nlo::trainer
