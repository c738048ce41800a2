// SPDX-License-Identifier: MIT
// Ranges of the readings in flight (nlo/measurement.h).
//   an angle           is unwrapped, and accepted within +-2^16 turns
//   a relative output  (T* reads it only through z - S y) is unwrapped with its own wrap W, a power of two, so that
//                      subtracting W is exact.
//                      The output is accepted within +-64 W
//   any other          is clamped to its declared range
// W exists only in flight: for training and evaluation such an output is not an angle.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"

namespace nlo::codegen {

/// Ranges of the readings, n_r each.
struct FlownRanges {
  Eigen::VectorXd min, max;            ///< measurements beyond are clamped, or held if the reading wraps
  Eigen::VectorXd wrap;                ///< 0: clamped
  Eigen::VectorXd kept_min, kept_max;  ///< range that T* reads: readings that wrap are within half a turn
  bool any_wraps() const { return (wrap.array() > 0.0).any(); }
};

FlownRanges flown_ranges(const Model& model);

/// Returns W of a relative output; 0 for any other reading. W is at least twice the width of the declared range and
/// twice its farther end, so that readings within the range are used unchanged.
double relative_wrap(const Model& model, int reading);

/// Returns angle / turn, rounded to an integer as in flight; 0 for exactly half a turn.
double whole_turns(double angle, double turn);

}  // namespace nlo::codegen
