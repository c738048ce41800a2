// SPDX-License-Identifier: MIT
// Measurements from training that are stored with the model. `nlo export` tests the arithmetic of an export on them.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nlo::codegen {

/// N samples after a reset, as integers: the counts of a sensor with some 14 bits.
struct FlightRun {
  Eigen::MatrixXi outputs;  ///< n_y x N, noise included; angles without whole turns
  Eigen::MatrixXi inputs;   ///< n_u x N
  Eigen::VectorXi dt;       ///< N, time since the last sample; size 0: one sample period each
};

/// value = step * count. Steps are powers of two and counts have 24 bits at most, so that floats hold every value.
struct Flight {
  Eigen::VectorXd output_step, input_step;  ///< n_y, n_u, in the channels' units
  double dt_step_s = 0.0;
  std::vector<FlightRun> runs = {};  ///< empty: nothing was recorded

  Eigen::Index samples() const {
    Eigen::Index count = 0;
    for (const FlightRun& run : runs) count += run.outputs.cols();
    return count;
  }
};

inline constexpr int kMostFlightCount = 1 << 24;    ///< |count|
inline constexpr int kMostFlightSamples = 1 << 20;  ///< sum over all runs
/// Returns the smallest power of two >= 2^-14 `range`; a larger one if `largest`, the largest |value|, needs it.
double flight_step(double range, double largest);

}  // namespace nlo::codegen
