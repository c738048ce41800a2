// SPDX-License-Identifier: MIT
// From a structure to what rolls it out. A new structure is one line here and one class in this folder.
#pragma once

#include <memory>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/sensitivity/latent_dynamics.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// The right-hand side of a structure's latent system, for the general route; in double for tests of gradients.
template <class Scalar>
std::unique_ptr<OdeDynamics<Scalar>> make_ode_dynamics(const ObserverStructure& structure);

/// How training rolls a structure out: by the filter where the latent system is linear, unless [training] gradient asks
/// for the general route.  steps_s: the distinct steps of the data, which must outlive the result.
std::unique_ptr<LatentDynamics> make_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                              const std::vector<double>& steps_s, int threads);

}  // namespace nlo::trainer
