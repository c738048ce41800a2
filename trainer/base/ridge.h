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
  ///   x        n_x x N; columns of weight 0 may hold any value, NaN included
  ///   weights  N, >= 0
  void add(const Eigen::MatrixXd& u, const Eigen::MatrixXd& x, const Eigen::VectorXd& weights);

  /// Returns the sum of the added weights. A fit needs weight() > 0.
  double weight() const { return weight_; }

  /// Returns W, n_x x (1 + n_u): [intercept, columns of u]. `ridge` > 0 is relative to the power of each column, so
  /// that collinear columns do no harm. Needs weight() > 0.
  Eigen::MatrixXd fit(double ridge) const;

  /// Adds the samples of another regression, with weights multiplied by `share`.
  void add(const Ridge& other, double share);

  /// Returns the mean of each state, n_x. Needs weight() > 0.
  Eigen::VectorXd mean() const { return cross_.col(0) / weight_; }

  /// Returns the mean squared error of W [1; u] for each state, n_x. Needs weight() > 0.
  Eigen::VectorXd squared_errors(const Eigen::MatrixXd& w) const;

 private:
  /// Sets the sums to zero before the first samples.
  void begin(Eigen::Index columns, Eigen::Index states);

  Eigen::MatrixXd gram_, cross_;  ///< weighted sums of [1; u] [1; u]' and of x [1; u]'
  Eigen::VectorXd squares_;       ///< weighted sums of x^2
  double weight_ = 0.0;
};

/// Ridge regression over runs that begin with a transient. Its errors are far larger than the settled ones and would
/// dominate the fit. Therefore times since the start are binned, three bins per octave, and all bins have equal weight.
/// An error counts relative to the error that is reachable in its bin:
///   weight of a sample = w_k / (weight of its bin (mean squared error there + (0.001 deviation of the state)^2))
/// The weights are found by a few fits, each with the errors of the previous one.
class TransientRidge {
 public:
  /// Like Ridge::add(). since_start: sample periods since the start of the run, N.
  void add(const Eigen::MatrixXd& u, const Eigen::MatrixXd& x, const Eigen::VectorXd& weights,
           const std::vector<int>& since_start);

  /// Like Ridge::weight().
  double weight() const;

  /// Like Ridge::fit().
  Eigen::MatrixXd fit(double ridge) const;

 private:
  std::vector<Ridge> bins_;
};

/// Returns `u` with a row of ones on top, the input of W of Ridge::fit().
Eigen::MatrixXd with_one(const Eigen::MatrixXd& u);

}  // namespace nlo::trainer
