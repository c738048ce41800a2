// SPDX-License-Identifier: MIT
// Ridge regression with an intercept, over samples that arrive in blocks:
//   W = argmin sum_k w_k |x_k - W [1; u_k]|^2 + ridge sum_k w_k |W'|^2     W': the columns of u, in units of their RMS
#pragma once

#include <Eigen/Core>

namespace nlo::trainer {

class Ridge {
 public:
  /// Adds N samples.
  ///   u        n_u x N
  ///   x        n_x x N; columns of weight 0 may be anything, NaN too
  ///   weights  N, >= 0
  void add(const Eigen::MatrixXd& u, const Eigen::MatrixXd& x, const Eigen::VectorXd& weights);

  /// The weights added so far, in sum; nothing can be fitted while it is zero.
  double weight() const { return weight_; }

  /// W, n_x x (1 + n_u): [intercept, columns of u]. `ridge` > 0 is relative to the power of each column, so that
  /// collinear columns stay harmless. weight() > 0.
  Eigen::MatrixXd fit(double ridge) const;

 private:
  Eigen::MatrixXd gram_, cross_;  ///< weighted sums of [1; u] [1; u]' and of x [1; u]'
  double weight_ = 0.0;
};

/// `u` with a row of ones on top, as W of Ridge::fit() needs it.
Eigen::MatrixXd with_one(const Eigen::MatrixXd& u);

}  // namespace nlo::trainer
