// SPDX-License-Identifier: MIT
// Estimators of the state in the loop of [feedback]: an observer, or a filter for comparison.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>

#include "codegen/model/model.h"
#include "trainer/base/noise.h"
#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// Estimates the states of one run sample by sample.
class LoopEstimator {
 public:
  virtual ~LoopEstimator() = default;

  /// Returns x_hat at the next sample, one value for each estimated state ([plant] `estimated`; all states if it is
  /// empty).
  ///   y  n_y; NaN: did not arrive
  ///   u  n_u, the input since the last sample (input_hold = "zero_order")
  virtual Eigen::VectorXd step(const Eigen::VectorXd& y, const Eigen::VectorXd& u) = 0;
};

/// Makes an estimator for run `run` of a set, at its start.
using LoopEstimators = std::function<std::unique_ptr<LoopEstimator>(std::uint64_t run)>;

/// Returns an observer in the arithmetic of its exports, for samples one period apart. Throws codegen::Error unless it
/// reads the outputs and inputs of the plant and estimates the states of the experiment's [plant].
LoopEstimators observer_in_loop(const codegen::Model& model, const Experiment& experiment, const Plant& plant);

/// Adds sensor noise (measurement_noise.h) before the estimators. In run i of a set it is the noise that evaluate()
/// with this noise and seed adds to run i.
LoopEstimators with_noise(LoopEstimators estimators, const NoiseConfig& noise, std::uint64_t seed);

}  // namespace nlo::trainer
