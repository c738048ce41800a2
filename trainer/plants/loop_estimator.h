// SPDX-License-Identifier: MIT
// Estimators of the state inside the loop that [feedback] closes: an observer, or a filter beside it.
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

/// Estimates the states of one run from its samples as they come.
class LoopEstimator {
 public:
  virtual ~LoopEstimator() = default;

  /// x_hat at the next sample, one for each state that is estimated ([plant] `estimated`; all, where it names none).
  ///   y  n_y; NaN: did not arrive
  ///   u  n_u, the input before it (input_hold = "zero_order")
  virtual Eigen::VectorXd step(const Eigen::VectorXd& y, const Eigen::VectorXd& u) = 0;
};

/// One for run `run` of a set, at its start.
using LoopEstimators = std::function<std::unique_ptr<LoopEstimator>(std::uint64_t run)>;

/// An observer in the arithmetic of its exports, for samples a period apart. Throws codegen::Error unless it reads the
/// outputs and inputs of the plant and estimates the states that the experiment's [plant] says.
LoopEstimators observer_in_loop(const codegen::Model& model, const Experiment& experiment, const Plant& plant);

/// Puts sensors with this noise (measurement_noise.h) before the estimators. In run i of a set they read the same noise
/// that evaluate() with this noise and seed adds to run i.
LoopEstimators with_noise(LoopEstimators estimators, const NoiseConfig& noise, std::uint64_t seed);

}  // namespace nlo::trainer
