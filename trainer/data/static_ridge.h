// SPDX-License-Identifier: MIT
// An estimate without memory: a ridge regression from the last few samples of outputs and inputs, and their products.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// x_hat_k = W phi_k,  phi_k = [1; c; c_i c_j (i <= j)],  c = channels at samples k, k - 1, ... k - `samples` + 1
/// Channels are outputs and inputs scaled to unit deviation, an angle as its sine and cosine; before the first sample
/// they have its value. W minimises the squared error on the training logs + `ridge` |W|^2, relative to the power of
/// the features. An angle among the states is regressed as sine and cosine. Long logs are fitted at every n-th sample.
class StaticRidge {
 public:
  /// Throws codegen::Error if no truth counts in `training`.
  static StaticRidge fit(const Dataset& training, int samples = 3, double ridge = 1e-6);

  /// Returns estimates, n_x x N.
  Eigen::MatrixXd estimate(const Trajectory& run) const;

  /// Returns the number of entries of phi: the multiply-adds per state and step, without those of the products.
  Eigen::Index features() const { return weights_.cols(); }

 private:
  Eigen::MatrixXd channels_of(const Trajectory& run) const;
  /// Returns the features of the samples from, from + stride, ..., `count` of them; features x count. `channels`: all
  /// samples, normalised.
  Eigen::MatrixXd features_of(const Eigen::MatrixXd& channels, Eigen::Index from, Eigen::Index stride,
                              Eigen::Index count) const;
  Eigen::MatrixXd normalised(const Trajectory& run) const;

  std::vector<Channel> states_, outputs_;
  int samples_ = 3;
  Eigen::VectorXd mean_, scale_;  ///< for the channels of one sample
  Eigen::MatrixXd weights_;       ///< targets x features
};

}  // namespace nlo::trainer
