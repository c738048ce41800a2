// SPDX-License-Identifier: MIT
// Makes the dynamics of a structure for roll-outs.
#pragma once

#include <memory>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/gradients/sensitivity/latent_dynamics.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Returns the dynamics with which training rolls a structure out: the exact filter if the latent system is linear and
/// [training] gradient is automatic, else the equations by RK4.
///   steps_s  the distinct steps of the data, which must outlive the result
std::unique_ptr<LatentDynamics> make_dynamics(const Experiment& experiment, const ObserverStructure& structure,
                                              const std::vector<double>& steps_s, int threads);

}  // namespace nlo::trainer
