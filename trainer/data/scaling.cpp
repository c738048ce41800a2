// SPDX-License-Identifier: MIT
#include "trainer/data/scaling.h"

#include <cmath>

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Two passes over (values n x N, weight N): the mean first, so that a large offset costs no digits.
template <typename Values, typename Weight>
Scaling weighted_scaling(const Dataset& data, Eigen::Index channels, Values values, Weight weight) {
  VectorXd sum = VectorXd::Zero(channels), squares = VectorXd::Zero(channels);
  double total = 0.0;
  for (const Trajectory& run : data.trajectories) {
    sum += values(run) * weight(run);
    total += weight(run).sum();
  }
  Scaling scaling{sum / total, {}};
  for (const Trajectory& run : data.trajectories)
    squares += (values(run).colwise() - scaling.mean).cwiseAbs2() * weight(run);
  scaling.deviation = (squares / total).cwiseSqrt();
  for (Eigen::Index i = 0; i < channels; ++i) {
    // What is left of a constant is rounding: 1e-12 of its size is far below any sensor's resolution.
    const bool moves = scaling.deviation[i] > 1e-12 * std::abs(scaling.mean[i]);
    if (!moves) scaling.deviation[i] = 1.0;
  }
  return scaling;
}

}  // namespace

Scaling output_scaling(const Dataset& training) {
  return weighted_scaling(
      training, static_cast<Eigen::Index>(training.outputs.size()),
      [](const Trajectory& run) -> const MatrixXd& { return run.outputs; },
      [](const Trajectory& run) -> VectorXd { return VectorXd::Ones(run.samples()); });
}

Scaling state_scaling(const Dataset& training) {
  return weighted_scaling(
      training, static_cast<Eigen::Index>(training.states.size()),
      [](const Trajectory& run) -> const MatrixXd& { return run.states; },
      [](const Trajectory& run) -> const VectorXd& { return run.weight; });
}

}  // namespace nlo::trainer
