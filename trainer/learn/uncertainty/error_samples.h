// SPDX-License-Identifier: MIT
// Errors of a model along roll-outs, with the inputs of its error head there.
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
  Eigen::MatrixXd errors;   ///< n_x x N, x_hat - x; angles the short way round
  Eigen::VectorXd weights;  ///< N, > 0: how much the truth counts
  std::vector<bool> known;  ///< z lies in the model's domain

  Eigen::Index size() const { return weights.size(); }
  /// `weights`, 0 outside of the domain; of all samples where none lies within it.
  Eigen::VectorXd known_weights() const;
  void append(const ErrorSamples& more);
};

/// Some `count` of the samples of `rollout` whose truth counts, or all of them where they are fewer: evenly over its
/// segments, each from another place on. `rollout`: with the parameters of `model`, whose T* has a hidden layer.
ErrorSamples error_samples(const codegen::Model& model, const Rollout& rollout, Eigen::Index count);

}  // namespace nlo::trainer
