// SPDX-License-Identifier: MIT
// Symmetric mean absolute percentage error of one run, in %: 0 is exact, 200 is the largest value. Two versions are in
// use, and their values differ much: by components, a small error of a state near zero counts as much as a large error
// of a large state.
#pragma once

#include <Eigen/Core>

namespace nlo::trainer {

/// Returns 100 times the mean of 2 |x_i - x_hat_i| / (|x_i| + |x_hat_i|) over components and samples. A term with x_i =
/// x_hat_i = 0 counts as 0.
///   truth, estimate  n_x x N
double smape_of_components(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& estimate);

/// Returns 100 times the mean of 2 |x - x_hat| / (|x| + |x_hat|) over the samples at t >= from_s, with Euclidean norms.
/// NaN if there are no such samples.
double smape_of_norms(const Eigen::MatrixXd& truth, const Eigen::MatrixXd& estimate, const Eigen::VectorXd& time_s,
                      double from_s = 0.0);

}  // namespace nlo::trainer
