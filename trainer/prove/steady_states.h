// SPDX-License-Identifier: MIT
// The states of a plant and its observer after both have settled.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// States at which a plant arrives, and the latent states of an observer there.
struct SteadyStates {
  Eigen::MatrixXd visited;  ///< with the disturbance, n_x x N
  Eigen::MatrixXd x, z;     ///< without noise and disturbance, n_x x M and n_z x M
};

/// Computes them from the second half of simulated runs with the experiment's initial states. If the observer settles
/// slowly, the runs are longer.
SteadyStates steady_states(const codegen::Model& model, const Plant& plant, SimulationConfig simulation,
                           double disturbance, int trajectories, std::uint64_t seed);

}  // namespace nlo::trainer
