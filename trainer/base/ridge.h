// SPDX-License-Identifier: MIT
// Ridge regression with an intercept, over samples that arrive in blocks:
//   W = argmin sum_k w_k |x_k - W [1; u_k]|^2 + ridge sum_k w_k |W'|^2     W': the columns of u, in units of their RMS
#pragma once

#include <Eigen/Core>
#include <vector>

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

  /// Adds the samples of another, whose weights count `share` times.
  void add(const Ridge& other, double share);

  /// The mean of each state, n_x. weight() > 0.
  Eigen::VectorXd mean() const { return cross_.col(0) / weight_; }

  /// Mean of the squared errors of W [1; u] for each state, n_x. weight() > 0.
  Eigen::VectorXd squared_errors(const Eigen::MatrixXd& w) const;

 private:
  /// Sums of zero, at the first samples.
  void begin(Eigen::Index columns, Eigen::Index states);

  Eigen::MatrixXd gram_, cross_;  ///< weighted sums of [1; u] [1; u]' and of x [1; u]'
  Eigen::VectorXd squares_;       ///< weighted sums of x^2
  double weight_ = 0.0;
};

/// Ridge regression over runs that begin with a transient, whose errors are far larger than the settled ones and would
/// decide alone. Times since the start are binned, three bins in each octave. All bins count alike. In each, an error
/// counts relative to the one that is reachable there:
///   weight of a sample = w_k / (weight of its bin (mean squared error there + (0.001 deviation of the state)^2))
/// by a few fits, each with the errors of the one before.
class TransientRidge {
 public:
  /// As Ridge::add(). since_start: sample periods since the start of the run, N.
  void add(const Eigen::MatrixXd& u, const Eigen::MatrixXd& x, const Eigen::VectorXd& weights,
           const std::vector<int>& since_start);

  /// As Ridge::weight().
  double weight() const;

  /// As Ridge::fit().
  Eigen::MatrixXd fit(double ridge) const;

 private:
  std::vector<Ridge> bins_;
};

/// `u` with a row of ones on top, as W of Ridge::fit() needs it.
Eigen::MatrixXd with_one(const Eigen::MatrixXd& u);

}  // namespace nlo::trainer
