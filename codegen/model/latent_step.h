// SPDX-License-Identifier: MIT
// The latent recurrence of a KKL observer in double, z+ = z + (A - I) z + B0 y_k + B1 y_{k+1}, by the discretisation of
// the runtime, with sizes at run time.
#pragma once

#include <nlo/exponential_rk.h>
#include <Eigen/Core>

#include "codegen/model/model.h"

namespace nlo::codegen {

struct StepMatrices {
  Eigen::VectorXd a_minus_1;  ///< n_z, in the order of the eigenvalues: (re, im) of each pair, then real modes
  Eigen::MatrixXd b0, b1;     ///< n_z x n_r
};

/// Discretises (D, F) over a step of `dt_s`. If `dt_s` is not the sample period, an rk4 model is stepped by the
/// first-order hold, because its own coefficients approximate that hold and are stable only near the sample period.
StepMatrices latent_step(const Model& model, double dt_s);

/// Further coefficients of a driven KKL observer: D and F over half the step, and the weights of phi(z) u.
struct ForcedStepMatrices {
  StepMatrices half;
  ForcedWeights<Eigen::VectorXd> weights;  ///< n_z each, in the order of the eigenvalues
};
ForcedStepMatrices forced_latent_step(const Model& model, double dt_s);

/// Returns coefficients of the modes, in the order of the eigenvalues, as a block-diagonal matrix, n_z x n_z.
Eigen::MatrixXd block_diagonal(const Model& model, const Eigen::VectorXd& modes);

/// Returns S = -D^-1 F, n_z x n_r: the steady state per unit of a constant reading. Zero if the latent system is not
/// linear.
Eigen::MatrixXd steady_gain(const Model& model);

}  // namespace nlo::codegen
