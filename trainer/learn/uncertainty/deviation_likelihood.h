// SPDX-License-Identifier: MIT
// The Gaussian likelihood of one state's errors r whose log standard deviation is linear in features phi:
//   l(p) = sum_k w_k (s_k + r_k^2 exp(-2 s_k) / 2) / sum_k w_k + ridge |W|^2 / 2,   s = W phi + b,  p = [W; b]
// Each term is convex in s, so l is convex in p, and Newton's method finds its minimum.
#pragma once

#include <Eigen/Core>

namespace nlo::trainer {

struct DeviationLikelihood {
  double value = 0.0;
  Eigen::VectorXd gradient;  ///< n + 1
  Eigen::MatrixXd hessian;   ///< n + 1 x n + 1
};

/// Returns l and its derivatives at `parameters`, n + 1.
///   features  n x N
///   squares   N, r^2, none of them zero
///   weights   N, >= 0, not all zero
DeviationLikelihood deviation_likelihood(const Eigen::MatrixXd& features, const Eigen::VectorXd& squares,
                                         const Eigen::VectorXd& weights, const Eigen::VectorXd& parameters,
                                         double ridge);

/// Returns l only.
double deviation_cost(const Eigen::MatrixXd& features, const Eigen::VectorXd& squares, const Eigen::VectorXd& weights,
                      const Eigen::VectorXd& parameters, double ridge);

/// Returns the minimum of l. Newton steps, halved until l falls, start from one standard deviation for all errors (W =
/// 0).
Eigen::VectorXd most_likely_deviation(const Eigen::MatrixXd& features, const Eigen::VectorXd& squares,
                                      const Eigen::VectorXd& weights, double ridge);

}  // namespace nlo::trainer
