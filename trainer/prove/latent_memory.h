// SPDX-License-Identifier: MIT
// The memory of a KKL observer's latent state: z+ = A z + B0 y_k + B1 y_(k+1). An error v of the outputs and an error
// d of the step have the effect
//   e_k = sum over i >= 0 of  A^i B1 v_(k-i)  +  A^i B0 v_(k-1-i)  -  A^i d_(k-i)
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"

namespace nlo::trainer {

struct LatentMemory {
  Eigen::MatrixXd a, b0, b1;  ///< matrices of a step
  Eigen::Index steps = 0;     ///< number of steps that are stored; `noise_tail` and `step_tail` bound the rest
  Eigen::MatrixXd noise;      ///< n_z x (steps + 1) n_y: de_k/dv_k, de_k/dv_(k-1), ...
  Eigen::MatrixXd powers;     ///< n_z x steps n_z: I, A, A^2, ...
  double tail = 0.0;          ///< bound of the sum of the norms of all powers that are not stored
  double rounding = 0.0;      ///< error of each entry of `noise` and `powers`, relative to the largest entry

  explicit LatentMemory(const codegen::Model& model);

  /// Returns a bound of |row e| for each row of `rows` (m x n_z), if |v_j| <= noise_j and |d_i| <= step_i in every
  /// step. `feedthrough` (m x n_y, or 0 x 0): additional direct effect of v_k on the rows.
  Eigen::VectorXd largest(const Eigen::MatrixXd& rows, const Eigen::VectorXd& noise_size,
                          const Eigen::VectorXd& step_size, const Eigen::MatrixXd& feedthrough = {}) const;
};

}  // namespace nlo::trainer
