// SPDX-License-Identifier: MIT
// Observer with a prior: an extended Kalman filter with the known equations f and h of the plant, and learned gated
// units that set its noise variances and correct its estimate.
//   x-  = one RK4 step of x' = f(x, u) from x         the prior; P- likewise by P' = F P + P F', F = df/dx
//   nu  = y - h(x-)                                   the innovation; 0 for an output that has not arrived
//   w   = [s(nu, fine); s(nu, coarse); y; u; x-]      s(v, c) = v / (c + |v|), between -1 and 1
//   m   states of gated units (gated.h) that read w instead of y
//   [K; b; c_q; c_r] = correction([m; w])             K row by row
//   x, P  measurement update (nlo/covariance.h) with q = state_noise exp(c_q) and r = output_noise exp(c_r), by the
//         outputs that have arrived
//   x  <- x + K s(nu, coarse) + b
//   x_hat = T*([m; x; p])
// A model without units has none of fine, coarse, gates, candidate and correction: K, b, c_q and c_r are 0, and it is
// the extended Kalman filter itself, z = [x; p].
// x has the n_x estimated states, then the plant's states that are not estimated; below, n_s is the number of both.
// [x; p] is limited to [state_min, state_max]. z = [m; x; p], p: the upper triangle of P, row by row.
#pragma once

#include "codegen/model/equations.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

struct Prior {
  EquationTexts equations;
  Eigen::VectorXd state_min, state_max;       ///< limits of [x; p], a little beyond the states' range
  Eigen::VectorXd fine, coarse;               ///< n_y, innovations at which s is 1/2
  Eigen::VectorXd state_noise, output_noise;  ///< variances at c_q = 0 (n_s, per sample period) and c_r = 0 (n_y)
  Network gates;                              ///< [m; w] -> [a_s; a_g]: one layer
  Network candidate;                          ///< [g m; w] -> n_m, before the tanh: one layer
  Network correction;                         ///< [m; w] -> n_s (n_y + 2) + n_y: one layer
  Network inverse_map;                        ///< T*: z or [z; y] -> x_hat
};

}  // namespace nlo::codegen
