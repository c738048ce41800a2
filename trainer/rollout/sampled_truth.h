// SPDX-License-Identifier: MIT
// Samples of roll-outs with their truth as matrices, for fitting and comparing readouts.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// N samples at which an estimate is required and the truth counts.
struct SampledTruth {
  Eigen::MatrixXd z;             ///< n_z x N
  Eigen::MatrixXd y;             ///< n_r x N, validated readings of the observer
  Eigen::MatrixXd x;             ///< n_x x N
  Eigen::VectorXd weights;       ///< N, > 0
  std::vector<int> since_start;  ///< N, sample periods since the start of the segment
};

/// Returns `count` of the samples of `rollout` whose truth counts, or all if there are fewer, spread evenly over its
/// segments. `model` gives the number of rows.
SampledTruth sample_truth(const codegen::Model& model, const Rollout& rollout, Eigen::Index count);

/// Weights that are zero outside of a time window after the start.
struct WindowWeights {
  Eigen::VectorXd transient;  ///< N, for samples less than `from` sample periods after the start
  Eigen::VectorXd settled;    ///< N, for all later samples
  bool has_both() const { return transient.sum() > 0.0 && settled.sum() > 0.0; }
};

/// Splits the weights of `samples` at `from` [sample periods since the start].
WindowWeights split_weights(const SampledTruth& samples, double from);

/// Returns the mean of `values`, N, with weights whose sum is > 0.
double weighted_mean(const Eigen::RowVectorXd& values, const Eigen::VectorXd& weights);

/// Returns the weighted mean square of the deviations from the weighted mean.
double weighted_variance(const Eigen::RowVectorXd& values, const Eigen::VectorXd& weights);

/// Returns x_hat - x, n_x x N; for angles the shorter way round.
Eigen::MatrixXd errors_of(const Eigen::MatrixXd& estimates, const Eigen::MatrixXd& truth,
                          const std::vector<codegen::Channel>& states);

}  // namespace nlo::trainer
