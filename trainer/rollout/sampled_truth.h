// SPDX-License-Identifier: MIT
// Samples of roll-outs with their truth, as matrices, for fitting and judging readouts.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// N samples at which an estimate is asked for and the truth counts.
struct SampledTruth {
  Eigen::MatrixXd z;             ///< n_z x N
  Eigen::MatrixXd y;             ///< n_r x N, readings as the observer has them
  Eigen::MatrixXd x;             ///< n_x x N
  Eigen::VectorXd weights;       ///< N, > 0
  std::vector<int> since_start;  ///< N, sample periods since the start of the segment
};

/// Some `count` of the samples of `rollout` whose truth counts, or all of them where they are fewer: evenly over its
/// segments, each from another place on. `model` says how many rows there are.
SampledTruth sample_truth(const codegen::Model& model, const Rollout& rollout, Eigen::Index count);

/// Weights that are zero outside of a window of time since the start.
struct WindowWeights {
  Eigen::VectorXd transient;  ///< N, of the samples less than `from` sample periods after the start
  Eigen::VectorXd settled;    ///< N, of the others
  bool has_both() const { return transient.sum() > 0.0 && settled.sum() > 0.0; }
};

/// Splits the weights of `samples` at `from` [sample periods since the start].
WindowWeights split_weights(const SampledTruth& samples, double from);

/// Mean of `values`, N, with weights whose sum is > 0.
double weighted_mean(const Eigen::RowVectorXd& values, const Eigen::VectorXd& weights);

/// Weighted mean square of the deviations from the weighted mean.
double weighted_variance(const Eigen::RowVectorXd& values, const Eigen::VectorXd& weights);

/// x_hat - x, n_x x N; angles among the states the short way round.
Eigen::MatrixXd errors_of(const Eigen::MatrixXd& estimates, const Eigen::MatrixXd& truth,
                          const std::vector<codegen::Channel>& states);

}  // namespace nlo::trainer
