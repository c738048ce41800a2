// SPDX-License-Identifier: MIT
// Ranges of the readings as they fly (nlo/measurement.h).
//   an angle           is continued over its full turn, and accepted within +-2^16 turns
//   a relative output  (T* knows it only through z - S y) is continued over a wrap W of its own: a power of two, so
//                      that taking W away is exact. It is accepted within +-64 W
//   any other          is clamped to its declared range
// W is flown and nothing else: training and evaluation take such an output as no angle.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"

namespace nlo::codegen {

/// n_r each.
struct FlownRanges {
  Eigen::VectorXd min, max;            ///< a measurement beyond is clamped, or held where it wraps
  Eigen::VectorXd wrap;                ///< 0: clamped
  Eigen::VectorXd kept_min, kept_max;  ///< as T* reads it: what wraps has been turned back to within half a turn
  bool any_wraps() const { return (wrap.array() > 0.0).any(); }
};

FlownRanges flown_ranges(const Model& model);

/// W of a relative output; 0 for any other reading. At least twice the width of the declared range, and at least twice
/// its farther end: what is within the range is neither continued over W nor turned back.
double relative_wrap(const Model& model, int reading);

/// angle / turn, rounded to an integer as in flight; exactly half a turn counts as none.
double whole_turns(double angle, double turn);

}  // namespace nlo::codegen
