// SPDX-License-Identifier: MIT
// [training] mirror: finds the channels that change their sign in the mirror image of a run.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "codegen/model/model.h"

namespace nlo::trainer {

/// A plant is odd if f(-x, -u) = -f(x, u) and h(-x) = -h(x), except for the channels that are declared even. Then the
/// mirror image of each run is also a run.
struct Mirror {
  std::vector<bool> readings, states;  ///< true: changes its sign. readings: outputs, then inputs

  bool none() const { return readings.empty() && states.empty(); }  ///< true if nothing is mirrored

  /// Returns -1 or 1, the factor of a reading or state in a mirrored run.
  float of_reading(std::size_t row) const { return readings[row] ? -1.0F : 1.0F; }
  float of_state(std::size_t row) const { return states[row] ? -1.0F : 1.0F; }
};

/// Returns the mirror for the channels `odd`, which change their sign; Mirror::none() if it is empty. NAME may also be
/// an angle with the channels NAME_sin and NAME_cos; then only the sine changes its sign. Names that are not among the
/// channels (a state that is not estimated) are ignored.
Mirror mirror_of(const std::vector<std::string>& odd, const std::vector<codegen::Channel>& readings,
                 const std::vector<codegen::Channel>& states);

/// Widens the ranges of readings to include their mirror images. An empty range (low > high) is not changed.
void widen_by_mirror(const Mirror& mirror, Eigen::VectorXd& low, Eigen::VectorXd& high);

}  // namespace nlo::trainer
