// SPDX-License-Identifier: MIT
// The states of a plant and its observer after both have settled.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// States of a plant on settled runs, and the latent states of an observer at the same times.
struct SteadyStates {
  Eigen::MatrixXd visited;  ///< states with the disturbance, n_x x N
  Eigen::MatrixXd x, z;     ///< states and latent states without noise and disturbance, n_x x M and n_z x M
};

/// Takes the states from the second half of simulated runs that start at the experiment's initial states. If the
/// observer settles slowly, the runs are longer.
SteadyStates steady_states(const codegen::Model& model, const Plant& plant, SimulationConfig simulation,
                           double disturbance, int trajectories, std::uint64_t seed);

}  // namespace nlo::trainer
