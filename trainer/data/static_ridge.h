// SPDX-License-Identifier: MIT
// An estimate without memory: a ridge regression from the last few samples of outputs and inputs, and their products.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// x_hat_k = W phi_k,  phi_k = [1; c; c_i c_j (i <= j)],  c = channels at samples k, k - 1, ... k - `samples` + 1
/// with outputs and inputs as channels of unit deviation, an angle as its sine and cosine; the first sample stands for
/// those before it. W minimises the squared error on the training logs + `ridge` |W|^2 relative to the features' power.
/// An angle among the states is regressed as sine and cosine. Long logs are fitted at every so many samples.
class StaticRidge {
 public:
  /// Throws codegen::Error when no truth counts in `training`.
  static StaticRidge fit(const Dataset& training, int samples = 3, double ridge = 1e-6);

  /// n_x x N.
  Eigen::MatrixXd estimate(const Trajectory& run) const;

  /// Entries of phi: multiply-adds per state and step, but for as many products.
  Eigen::Index features() const { return weights_.cols(); }

 private:
  Eigen::MatrixXd channels_of(const Trajectory& run) const;
  /// Features of the samples from, from + stride, ..., `count` of them; features x count. `channels`: all samples,
  /// normalised.
  Eigen::MatrixXd features_of(const Eigen::MatrixXd& channels, Eigen::Index from, Eigen::Index stride,
                              Eigen::Index count) const;
  Eigen::MatrixXd normalised(const Trajectory& run) const;

  std::vector<Channel> states_, outputs_;
  int samples_ = 3;
  Eigen::VectorXd mean_, scale_;  ///< for the channels of one sample
  Eigen::MatrixXd weights_;       ///< targets x features
};

}  // namespace nlo::trainer
