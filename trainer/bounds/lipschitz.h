// SPDX-License-Identifier: MIT
// How much the inverse map T* of a model can amplify an error of z, or of the y it reads: from above, proven from the
// weights; from below, the largest slope found at samples. Spectral norms, in the states' units.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"

namespace nlo::trainer {

/// |x_hat(z, y) - x_hat(z', y')| <= latent |z - z'| + output |y - y'|.
struct LipschitzConstants {
  double latent = 0.0;
  double output = 0.0;  ///< 0 when no feature reads y
};

/// Holds for all z and y. Slopes of the activation lie in [c - r, c + r] (tanh and relu: 1/2 +- 1/2), so a Jacobian is
/// W_L (c I + r S) W_(L-1) ... W_1 with unknown |S| <= 1: multiplied out, and each unbroken run of layers bounded by
/// the norm of its product (Combettes and Pesquet 2020). Never above the product of the layers' norms; exact for one
/// layer. Features, normalisation, scales and the linear path are part of it.
LipschitzConstants lipschitz_upper(const codegen::Model& model);

/// The largest Jacobian norm over the columns of z (n_z x B) and y (n_y x B), by forward differentiation: no constant
/// can be smaller.
LipschitzConstants lipschitz_sampled(const codegen::Model& model, const Eigen::MatrixXd& z, const Eigen::MatrixXd& y);

/// d x_hat / d [z; y] at one point, n_x x (n_z + n_y).
Eigen::MatrixXd inverse_map_jacobian(const codegen::Model& model, const Eigen::VectorXd& z, const Eigen::VectorXd& y);

/// Largest singular value.
double spectral_norm(const Eigen::MatrixXd& matrix);

}  // namespace nlo::trainer
