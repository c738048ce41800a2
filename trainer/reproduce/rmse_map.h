// SPDX-License-Identifier: MIT
// How well an observer does from each initial state of a grid.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// sqrt(mean over the run of |x - x_hat|^2), without noise, for a plant of two states.
///   x1, x2   initial states along each axis
///   threads  0: all cores; does not change the result
/// Returns x2.size() x x1.size(). Throws codegen::Error when a run leaves the numbers.
Eigen::MatrixXd rmse_map(const codegen::Model& model, const PlantConfig& plant, const SimulationConfig& simulation,
                         const Eigen::VectorXd& x1, const Eigen::VectorXd& x2, int threads);

}  // namespace nlo::trainer
