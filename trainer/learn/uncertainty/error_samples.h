// SPDX-License-Identifier: MIT
// Errors of a model along roll-outs, with the inputs of its error head.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "codegen/model/model.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// N samples.
struct ErrorSamples {
  Eigen::MatrixXd hidden;   ///< n_h x N, the last hidden layer of T*
  Eigen::MatrixXd errors;   ///< n_x x N, x_hat - x; for angles the difference that is closest to 0
  Eigen::VectorXd weights;  ///< N, > 0: weight of the truth
  std::vector<bool> known;  ///< z lies in the model's domain

  Eigen::Index size() const { return weights.size(); }
  /// Returns `weights`, with 0 outside of the domain; if no sample is within it, returns `weights` unchanged.
  Eigen::VectorXd known_weights() const;
  void append(const ErrorSamples& more);
};

/// Returns about `count` of the samples of `rollout` whose truth counts, or all if there are fewer. They are spread
/// evenly over its segments, with a different offset in each segment. `rollout` must use the parameters of `model`,
/// whose T* has a hidden layer.
ErrorSamples error_samples(const codegen::Model& model, const Rollout& rollout, Eigen::Index count);

}  // namespace nlo::trainer
