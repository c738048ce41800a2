// SPDX-License-Identifier: MIT
// Compares a control loop that feeds back estimates with the loop that feeds back the true state.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct ClosedLoopCost {
  Eigen::VectorXd deviation;  ///< n_x, RMS over runs and samples of x in this loop minus x in the loop of the true
                              ///< state
  int runs = 0;
  /// Number of runs in which a state exceeds kLeft times its largest value in any run of the true state's loop.
  int left = 0;
  /// Means of [feedback] cost over runs and samples, in this loop and in the loop of the true state; empty without a
  /// cost.
  std::optional<double> cost = {}, of_true_state = {};
};

inline constexpr double kLeft = 2.0;

/// Compares two sets of runs that begin at the same states with the same references. Throws codegen::Error unless they
/// have the same number of runs.
ClosedLoopCost closed_loop_cost(const Dataset& of_true_state, const Dataset& of_estimator);

/// Returns the mean over runs and samples of [feedback] cost; nothing without a cost. Throws codegen::Error if it is
/// NaN.
std::optional<double> mean_cost(const Experiment& experiment, const Plant& plant, const Dataset& runs);

/// Returns one line for readers.
std::string to_text(const ClosedLoopCost& cost, const std::vector<Channel>& states);

}  // namespace nlo::trainer
