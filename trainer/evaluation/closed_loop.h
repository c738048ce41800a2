// SPDX-License-Identifier: MIT
// What a loop that is closed by estimates costs beside the same loop closed by the true state.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "trainer/base/noise.h"
#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/loop_estimator.h"

namespace nlo::trainer {

struct ClosedLoopCost {
  Eigen::VectorXd deviation;  ///< n_x, RMS over runs and samples of x in this loop less x in the loop of the true state
  int runs = 0;
  int left = 0;  ///< runs in which a state goes beyond kLeft times what it reaches in any run of the true state's loop
  /// Means over runs and samples of [feedback] cost, and of the same in the loop of the true state; without one: empty.
  std::optional<double> cost = {}, of_true_state = {};
};

inline constexpr double kLeft = 2.0;

/// Runs of both sets begin at the same states with the same references. Throws codegen::Error unless they are as many.
ClosedLoopCost closed_loop_cost(const Dataset& of_true_state, const Dataset& of_estimator);

/// Mean over runs and samples of [feedback] cost; empty where there is none. Throws codegen::Error where it is no number.
std::optional<double> mean_cost(const Experiment& experiment, const Plant& plant, const Dataset& runs);

/// For people, one line.
std::string to_text(const ClosedLoopCost& cost, const std::vector<Channel>& states);

/// The same estimators behind sensors with this noise (measurement_noise.h): what they read in run i of a set is what
/// evaluate() with the same noise and seed lays over run i.
LoopEstimators with_noise(LoopEstimators estimators, const NoiseConfig& noise, std::uint64_t seed);

/// Sensors in a loop measure when they are asked: the noise without its delays and jitter.
NoiseConfig without_shifts(NoiseConfig noise);

}  // namespace nlo::trainer
