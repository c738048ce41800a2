// SPDX-License-Identifier: MIT
// The search for large steady errors that runs beside their bound: simulated runs that stay in the region, noise and
// disturbance at full size with the signs that push one estimate away from the truth. It shares no code with the
// proof but the memory of the latent state: the reference observer flies, and the plant is simulated.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"
#include "trainer/plants/plant.h"
#include "trainer/prove/steady_error.h"

namespace nlo::trainer {

struct SteadyFound {
  Eigen::VectorXd error;          ///< the largest |x_hat_i - x_i|, n_x
  Eigen::VectorXd approximation;  ///< the same without noise and disturbance: over all states there, too
  int runs = 0;                   ///< number of runs that stayed in the region
};

/// From `starts` (n_x x N), states in the region, each for as long as the observer remembers.
SteadyFound largest_steady_error(const codegen::Model& model, const Plant& plant, const StateRegion& region,
                                 const SteadyStates& states, const Eigen::MatrixXd& starts,
                                 const SteadyQuestion& question);

}  // namespace nlo::trainer
