// SPDX-License-Identifier: MIT
// The plant of Proposition 2, dx/dt = f(x) + w with |w| <= w_bar: runs for the robustness measurement.
//
// Every even run is pushed in one direction all the time, every odd one in a fresh direction each sample period; both
// at full size. Directions are uniform on the sphere, from std::mt19937_64 as measurement_noise.h describes for seed
// and run.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct DisturbedRuns {
  Dataset set;

  /// Per output, the largest distance in the middle of a sample period between h(x) and the straight line through the
  /// samples around it (first-order hold), or the earlier sample (zero-order hold): n_y each.
  Eigen::VectorXd ramp_error, step_error;
};

/// Runs from the columns of `initial` (n_x x count), RK4 at the sample period with w held over each. With w_bar = 0 the
/// runs of simulate_from(). Throws codegen::Error when a run leaves the numbers.
DisturbedRuns simulate_disturbed(const Plant& plant, const SimulationConfig& config, const Eigen::MatrixXd& initial,
                                 double w_bar, std::uint64_t seed);

}  // namespace nlo::trainer
