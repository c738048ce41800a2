// SPDX-License-Identifier: MIT
// An estimate with the half widths of its intervals. error_head.h computes them; Monitor::widened() widens them.
#pragma once

#include "nlo/vector.h"

namespace nlo {

/// sigma of an unknown error, in the unit of the state; bound_95 is a multiple of it. A test such as
/// `bound_95[i] > limit` is then true for every limit.
inline constexpr float kUnknownSigma = 0x1p100F;

/// An estimate and the half widths of its 68 % and 95 % intervals, n_x each. 68 % of the errors were within sigma and
/// 95 % within bound_95, on runs that training has not seen, at the noise that the model was calibrated for.
template <class Scalar, int kNx>
struct EstimateWithError {
  Vector<Scalar, kNx> x_hat;
  Vector<Scalar, kNx> sigma;
  Vector<Scalar, kNx> bound_95;
};

}  // namespace nlo
