// SPDX-License-Identifier: MIT
// Proves a bound of a KKL observer's estimation error after it has forgotten its initial value. Assumes that the plant
// stays in a region, the error of each output is at most V, and the error of each state's derivative is at most W:
//
//   x_hat - x = [T*(T~(x), h(x)) - x]  +  J e,      e = z - T~(x)
//
// T~ is a spline that nearly solves (5) (forward_spline.h). Its residual, the remainder of the hold between
// two samples, the noise and the disturbance drive e through A, B0 and B1 (latent_memory.h), so e lies in a
// known set; the Jacobian J of T* over that set is enclosed by jacobian_enclosure.h. The region is cut into boxes until
// their bounds are close to the values at their centres. Rounding is part of every bound.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"
#include "trainer/prove/state_region.h"
#include "trainer/prove/steady_states.h"

namespace nlo::trainer {

struct SteadyQuestion {
  double noise = 0.0;          ///< V: the largest error of each sample of each output
  double disturbance = 0.0;    ///< W: the largest error of each state's derivative [state / s]
  std::int64_t boxes = 20000;  ///< largest number of boxes to examine
};

struct SteadyError {
  Eigen::VectorXd bound;          ///< bound of |x_hat_i - x_i|, n_x
  Eigen::VectorXd approximation;  ///< bound without noise and disturbance: |T*(T(x)) - x| for every T of (5)
  Eigen::MatrixXd where;          ///< n_x x n_x: column i is the centre of the box with the largest bound of state i
  double residual = 0.0;          ///< proven bound of the residual of (5): its largest row divided by the size of F y
  std::int64_t boxes = 0;         ///< number of examined boxes
};

/// Several maps solve (5); T~ approximates the map that the settled `states` show. The model is a KKL observer without
/// inputs. Throws codegen::Error if a proof is not possible: the equations of the plant have no derivative, or the
/// region has outputs or latent states beyond the ranges of the model.
SteadyError steady_error(const codegen::Model& model, const PlantConfig& plant, const StateRegion& region,
                         const SteadyStates& states, const SteadyQuestion& question);

}  // namespace nlo::trainer
