// SPDX-License-Identifier: MIT
// Outputs that may be missing for as long as they like: nlo/sensor_failures.h has the equations.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace nlo::codegen {

struct SensorFailures {
  std::vector<int> outputs;  ///< which of them, rising; empty: none
  Eigen::VectorXd rest;      ///< where each fades to, its mean in training; one for each
  double staleness_s = 1.0;  ///< time constant of fading, and of the staleness that T* reads

  bool none() const { return outputs.empty(); }
};

}  // namespace nlo::codegen
