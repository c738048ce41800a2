// SPDX-License-Identifier: MIT
// The estimator that a network must beat: the best linear map from its own features to the states, by ridge regression
//   x_hat = W [1; u],   W = argmin sum w |x - W [1; u]|^2 + ridge |W'|^2
// W' are the columns of W for features scaled to unit RMS, without the column of the constant 1. An angle among the
// states is regressed as sine and cosine. The settled samples have their own W, because the errors of the transient are
// far larger and determine the W over all samples. If features are multiplied by clocks, W already changes with time,
// and there is only one (TransientRidge).
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/replay/reference_observer.h"
#include "trainer/base/ridge.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

class LinearReadout {
 public:
  /// The features are those of the model's T*; for an observer without one, z and y.
  ///   settled_from_s  end of the transient [s since the start of a run]; 0: one W for all samples
  LinearReadout(const codegen::Model& model, double settled_from_s);

  /// Makes a readout for the states with a known truth: the rows of Trajectory::states.
  LinearReadout(const codegen::Model& model, std::vector<codegen::Channel> states, double settled_from_s);

  /// Adds a run of the model on training data, with the samples whose truth counts.
  void add(const codegen::Run& run, const Trajectory& truth);

  /// Solves for W. Throws codegen::Error if nothing was added.
  void fit();

  /// Returns estimates, n_x x N, for the samples of a run. Call it after fit().
  Eigen::MatrixXd estimate(const codegen::Run& run) const;

 private:
  Eigen::MatrixXd features(const codegen::Run& run) const;

  std::vector<codegen::Channel> states_;
  Eigen::MatrixXd map_;              ///< [z; y] or z to features, n_u x n_in
  Eigen::VectorXd mean_, scale_;     ///< n_u, normalisation of the training
  std::vector<int> clocks_;          ///< as codegen::Network::feature_clocks
  Eigen::Index settled_from_ = 0;    ///< first settled sample of a run
  Ridge ridge_, settled_;            ///< over all samples, over the settled ones
  TransientRidge of_products_;       ///< used instead if features are multiplied by clocks
  Eigen::MatrixXd weights_;          ///< W, states (an angle has two rows) x (1 + n_u)
  Eigen::MatrixXd settled_weights_;  ///< W of the settled samples; empty: weights_
};

}  // namespace nlo::trainer
