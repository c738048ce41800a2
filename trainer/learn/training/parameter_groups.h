// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/learn/optim/optimiser.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Rate and decay of each stretch of the parameters, in their order: eigenvalues, the latent system's network, T*, T.
std::vector<ParameterGroup> parameter_groups(const Experiment& experiment, const ObserverStructure& structure);

}  // namespace nlo::trainer
