// SPDX-License-Identifier: MIT
#include "tests/runtime/linear_oracles.h"

#include <unsupported/Eigen/MatrixFunctions>

namespace nlo::testing {

Eigen::MatrixXd exponential(const Eigen::MatrixXd& a) {
  return a.exp();
}

Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.partialPivLu().solve(b);
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd& a) {
  return solve(a, Eigen::MatrixXd::Identity(a.rows(), a.cols()));
}

Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a) {
  return solve(a.transpose() * a, a.transpose());
}

}  // namespace nlo::testing
