// SPDX-License-Identifier: MIT
// Searches for large steady errors, to check the proven bound. It simulates runs that stay in the region, with noise
// and disturbance of full size and the signs that push one estimate away from the truth. It shares no code with the
// proof except the memory of the latent state: it runs the reference observer and simulates the plant.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"
#include "trainer/plants/plant.h"
#include "trainer/prove/steady_error.h"

namespace nlo::trainer {

struct SteadyFound {
  Eigen::VectorXd error;          ///< the largest |x_hat_i - x_i|, n_x
  Eigen::VectorXd approximation;  ///< `error` without noise and disturbance, also over all states of the region
  int runs = 0;                   ///< number of runs that stayed in the region
};

/// Starts from `starts` (n_x x N), states in the region. Each run is as long as the observer's memory.
SteadyFound largest_steady_error(const codegen::Model& model, const Plant& plant, const StateRegion& region,
                                 const SteadyStates& states, const Eigen::MatrixXd& starts,
                                 const SteadyQuestion& question);

}  // namespace nlo::trainer
