// SPDX-License-Identifier: MIT
// Outputs that may be missing for any time. nlo/sensor_failures.h has the equations.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nlo::codegen {

struct SensorFailures {
  std::vector<int> outputs;  ///< their indices, rising; empty: none
  Eigen::VectorXd rest;      ///< mean of each in training, to which it decays while it is missing
  double staleness_s = 1.0;  ///< time constant of fading, and of the staleness that T* reads

  bool none() const { return outputs.empty(); }
};

}  // namespace nlo::codegen
