// SPDX-License-Identifier: MIT
// Symmetric mean absolute percentage error of one run, in %: 0 is exact, 200 the most. Two readings are in use, and
// they differ much: by components, a state that crosses zero costs as much as one that is far off.
#pragma once

#include <Eigen/Core>

namespace nlo::trainer {

/// 100 mean of 2 |x_i - x_hat_i| / (|x_i| + |x_hat_i|) over components and samples; where both are 0 it counts as 0.
///   truth, estimate  n_x x N
double smape_of_components(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& estimate);

/// 100 mean of 2 |x - x_hat| / (|x| + |x_hat|) over the samples at t >= from_s, with Euclidean norms; none: NaN.
double smape_of_norms(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& estimate, const Eigen::VectorXd& time_s,
                      double from_s = 0.0);

}  // namespace nlo::trainer
