// SPDX-License-Identifier: MIT
// Luenberger-like observer (15) of a partially known plant, dx/dt = A x + g(x), y = C x. The latent state is the
// estimate:
//   x_hat' = A x_hat + B u + g_hat(x_hat) + G (y - C x_hat)
#pragma once

#include <Eigen/Core>

#include "codegen/model/network.h"

namespace nlo::codegen {

struct Luenberger {
  Eigen::MatrixXd state_matrix;       ///< A, n_x x n_x
  Eigen::MatrixXd output_matrix;      ///< C, n_y x n_x
  Eigen::MatrixXd gain;               ///< G, n_x x n_y; A - G C must be Hurwitz
  Network nonlinearity;               ///< g_hat, n_x -> n_x
  Eigen::MatrixXd input_matrix = {};  ///< B, n_x x n_u; 0 x 0 if the model has no inputs
};

}  // namespace nlo::codegen
