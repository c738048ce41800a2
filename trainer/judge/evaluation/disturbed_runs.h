// SPDX-License-Identifier: MIT
// Simulates runs of the plant of Proposition 2, dx/dt = f(x) + w with |w| <= w_bar, to measure its robustness.
//
// In even runs w has a constant direction; in odd runs it has a new direction in each sample period. Its size is always
// w_bar. Directions are uniform on the sphere, from std::mt19937_64, seeded by seed and run as in measurement_noise.h.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct DisturbedRuns {
  Dataset set;

  /// Largest distance between h(x) and its hold in the middle of a sample period, for each output (n_y). ramp_error:
  /// first-order hold, the straight line through the neighbouring samples. step_error: zero-order hold, the earlier
  /// sample.
  Eigen::VectorXd ramp_error, step_error;
};

/// Simulates runs from the columns of `initial` (n_x x count) by RK4 at the sample period, with w held over each
/// period. With w_bar = 0 the runs equal those of simulate_from(). Throws codegen::Error if a run is not finite.
DisturbedRuns simulate_disturbed(const Plant& plant, const SimulationConfig& config, const Eigen::MatrixXd& initial,
                                 double w_bar, std::uint64_t seed);

}  // namespace nlo::trainer
