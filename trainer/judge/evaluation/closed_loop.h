// SPDX-License-Identifier: MIT
// The cost of a loop that is closed by estimates, beside the loop that is closed by the true state.
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
  Eigen::VectorXd deviation;  ///< n_x, RMS over runs and samples of x in this loop less x in the loop of the true state
  int runs = 0;
  /// Runs in which a state goes beyond kLeft times its largest value in any run of the true state's loop.
  int left = 0;
  /// Means over runs and samples of [feedback] cost, and of the same in the loop of the true state; without one: empty.
  std::optional<double> cost = {}, of_true_state = {};
};

inline constexpr double kLeft = 2.0;

/// Runs of both sets begin at the same states with the same references. Throws codegen::Error unless they are as many.
ClosedLoopCost closed_loop_cost(const Dataset& of_true_state, const Dataset& of_estimator);

/// Mean over runs and samples of [feedback] cost; empty where there is none.
/// Throws codegen::Error where it is no number.
std::optional<double> mean_cost(const Experiment& experiment, const Plant& plant, const Dataset& runs);

/// For people, one line.
std::string to_text(const ClosedLoopCost& cost, const std::vector<Channel>& states);

}  // namespace nlo::trainer
