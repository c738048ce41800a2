// SPDX-License-Identifier: MIT
// Finds the delay of an input, relative to its column, from logs alone. A measured quantity q of relative degree r = 0,
// 1 or 2, q^(r)(t) = phi(slow) + sum_j b_j u_j(t - d_j), satisfies over any stride of m samples
//   delta_m^r q(t)  =  (B_r * phi)(t)  +  sum_j b_j (B_r * u_j)(t - d_j)
// with the B-spline B_r of r boxes. For an input that is held, B_r * u is known exactly. The mean of the values one
// width before and after is subtracted from each term, which removes most of phi. A regression on level, square (for an
// angle: sine, cosine) and change of the measurements explains the rest. Causal lags of u are not in the regression,
// because they would explain a part of the delay. The residual over d has its minimum at the delay; between quarters of
// a sample it is a parabola. The choice of q, r and m whose delay is the most certain decides. Its uncertainty is its
// standard deviation and the change of the delay when the stride doubles, which is large if r is wrong.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/config/choices.h"

namespace nlo::trainer {

/// A part of a log on an even grid.
struct DelayRun {
  Eigen::MatrixXd measured;  ///< n_q x N, angles unwrapped
  Eigen::MatrixXd inputs;    ///< n_u x N, as in their columns
};

struct FoundDelay {
  double samples = 0.0;     ///< d; negative: the input acts before its column shows it
  double deviation = 0.0;   ///< standard deviation by the curvature of the residual [samples]
  double without = 0.0;     ///< residual of the decisive regression if all delays are 0, as a share of its variance
  double with = 0.0;        ///< residual of that regression with the delays that were found
  double explains = 0.0;    ///< share of the residual without this input that the input explains
  bool at_the_end = false;  ///< true if the residual still fell at the longest delay
};

/// Returns the delay of each input.
///   angles  n_q: full turn of the measured quantity, 0: not an angle
///   known   n_u: given delays [samples]; NaN: to be found
///   hold    hold of the inputs between samples, [observer] input_hold
///   longest largest delay of the search [samples]
/// Throws codegen::Error if the runs are too short for a regression, or if no input has an effect.
std::vector<FoundDelay> find_delays(const std::vector<DelayRun>& runs, const std::vector<double>& angles,
                                    const std::vector<double>& known, Hold hold, double longest);

}  // namespace nlo::trainer
