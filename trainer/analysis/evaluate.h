// SPDX-License-Identifier: MIT
// The test that everything here is judged by: an estimator sees the noisy outputs of every trajectory of a set, once,
// and its estimates are compared with the truth.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "codegen/model.h"
#include "trainer/analysis/metrics.h"
#include "trainer/data/dataset.h"
#include "trainer/noise.h"

namespace nlo::trainer {

/// Estimates over one run from reset, causal:
///   outputs  n_y x N  as measured
///   inputs   n_u x N  what excited the plant, without noise; 0 x 0 when nothing did
///   time_s   N
/// gives x_hat, n_x x N.
using Estimator = std::function<Eigen::MatrixXd(const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                                const Eigen::VectorXd& time_s)>;

/// Makes an estimator; each thread asks for its own, so that it may keep work memory.
using EstimatorFactory = std::function<Estimator()>;

/// One run of the test, kept for plots.
struct EvaluatedRun {
  Trajectory truth;              ///< clean outputs and states
  Eigen::MatrixXd measured;      ///< n_y x N, what the estimator saw
  Eigen::MatrixXd estimate;      ///< n_x x N
  std::string why = {};          ///< "first", "best", "worst": why it is among the examples; may be empty
  Eigen::VectorXd outside = {};  ///< N: 1 where z is outside of the training domain; size 0: not known
};

struct Evaluation {
  std::string estimator;  ///< "observer", "ekf", "constant"
  NoiseConfig noise;
  std::uint64_t seed = 0;
  int trajectories = 0;
  double horizon_s = 0.0;
  std::vector<Channel> states, outputs;
  ErrorMetrics metrics;
  std::vector<EvaluatedRun> examples;                                ///< the first trajectory, then the worst
  std::vector<std::pair<std::string, std::string>> excitation = {};  ///< of each input: name, expression over t
};

/// Strict noise (measurement_noise.h) on `clean`, then the estimator. `threads` 0: all cores. The result has the same
/// bytes for any number of threads.
Evaluation evaluate(const std::string& estimator, const EstimatorFactory& factory, const Dataset& clean,
                    const NoiseConfig& noise, std::uint64_t seed, int threads);

/// The observer in float, as it flies. A model without phi(z) u (25) has no use for the inputs.
EstimatorFactory observer_estimator(const codegen::Model& model, bool uniform_steps);

/// Always the mean state of `dataset`: what knowing nothing but the set's average is worth.
EstimatorFactory constant_estimator(const Dataset& dataset);

/// evaluate() of a model, whose examples also say where z leaves the training domain.
Evaluation evaluate_on_plant(const codegen::Model& model, const Dataset& clean, const NoiseConfig& noise,
                             std::uint64_t seed, int threads);

}  // namespace nlo::trainer
