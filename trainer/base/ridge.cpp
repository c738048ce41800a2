// SPDX-License-Identifier: MIT
#include "trainer/base/ridge.h"

#include "codegen/base/linear_algebra.h"

namespace nlo::trainer {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd with_one(const MatrixXd& u) {
  MatrixXd result(1 + u.rows(), u.cols());
  result.row(0).setOnes();
  result.bottomRows(u.rows()) = u;
  return result;
}

void Ridge::add(const MatrixXd& u, const MatrixXd& x, const VectorXd& weights) {
  const MatrixXd rows = with_one(u);
  if (gram_.size() == 0) {
    gram_ = MatrixXd::Zero(rows.rows(), rows.rows());
    cross_ = MatrixXd::Zero(x.rows(), rows.rows());
  }
  MatrixXd known = x;
  for (Index k = 0; k < x.cols(); ++k)  // NaN stays NaN when it is weighted by zero
    if (weights[k] <= 0.0) known.col(k).setZero();
  const MatrixXd weighted = rows.array().rowwise() * weights.transpose().array();
  gram_ += weighted * rows.transpose();
  cross_ += known * weighted.transpose();
  weight_ += weights.sum();
}

MatrixXd Ridge::fit(double ridge) const {
  const VectorXd power = (gram_.diagonal() / weight_).cwiseMax(1e-300).cwiseSqrt();
  MatrixXd normal = (gram_ / weight_).array() / (power * power.transpose()).array();
  normal.diagonal().tail(normal.rows() - 1).array() += ridge;
  const MatrixXd right = (cross_ / weight_).array().rowwise() / power.transpose().array();
  const MatrixXd weights = codegen::solve_symmetric(normal, right.transpose()).transpose();
  return weights.array().rowwise() / power.transpose().array();
}

}  // namespace nlo::trainer
