// SPDX-License-Identifier: MIT
// How much later than its column says an input acts, found from logs alone. A measured quantity q of relative degree
// r = 0, 1 or 2, q^(r)(t) = phi(slow) + sum_j b_j u_j(t - d_j), has over any stride of m samples
//   delta_m^r q(t)  =  (B_r * phi)(t)  +  sum_j b_j (B_r * u_j)(t - d_j)
// with the B-spline B_r of r boxes; of an input that is held, B_r * u is known exactly. What is a width before and
// after is taken off each term, which leaves next to nothing of phi; a regression on level, square (of an angle: sine,
// cosine) and change of the measurements takes the rest. Causal lags of u are left out on purpose: they would take up a
// part of the delay themselves. The residual over d has its minimum at the delay, a parabola between the quarters of a
// sample. Of all q, r and m that one decides whose delay is known best: by its own standard deviation and by how far it
// moves when the stride doubles, which it does where r is another one.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/config/choices.h"

namespace nlo::trainer {

/// A stretch of a log on an even grid.
struct DelayRun {
  Eigen::MatrixXd measured;  ///< n_q x N, angles unwrapped
  Eigen::MatrixXd inputs;    ///< n_u x N, as their columns have them
};

struct FoundDelay {
  double samples = 0.0;     ///< d; negative: the column shows the input after it acted
  double deviation = 0.0;   ///< its standard deviation by the curvature of the residual [samples]
  double without = 0.0;     ///< residual of the decisive regression with all delays 0, as a share of its variance
  double with = 0.0;        ///< the same with the delays found
  double explains = 0.0;    ///< the share that this input takes away of the residual without it
  bool at_the_end = false;  ///< the residual still fell at the longest delay that was tried
};

/// One for each input.
///   angles  n_q: full turn of the measured quantity, 0: no angle
///   known   n_u: delays [samples] that are given; NaN where they are to be found
///   hold    of the inputs between samples, as [observer] input_hold
///   longest largest delay that is tried [samples]
/// Throws codegen::Error when the runs are too short for a regression, or no input moves anything.
std::vector<FoundDelay> find_delays(const std::vector<DelayRun>& runs, const std::vector<double>& angles,
                                    const std::vector<double>& known, Hold hold, double longest);

}  // namespace nlo::trainer
