// SPDX-License-Identifier: MIT
// Makes the dynamics of a structure for roll-outs.
#pragma once

#include <memory>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/gradients/sensitivity/latent_dynamics.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// How training rolls a structure out: by the filter where the latent system is linear, unless [training] gradient asks
/// for the general route.  steps_s: the distinct steps of the data, which must outlive the result.
std::unique_ptr<LatentDynamics> make_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                              const std::vector<double>& steps_s, int threads);

}  // namespace nlo::trainer
