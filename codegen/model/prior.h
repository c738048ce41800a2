// SPDX-License-Identifier: MIT
// Observer with a prior: the plant's known equations f and h, stepped as an extended Kalman filter whose noises gated
// units choose, and corrected by what those have learned.
//   x-  = x one step on by x' = f(x, u), RK4          the prior; with it P' = F P + P F', F = df/dx
//   nu  = y - h(x-)                                   the innovation
//   w   = [s(nu, fine); s(nu, coarse); y; u; x-]      s(v, c) = v / (c + |v|), between -1 and 1
//   m   gated units (gated.h) that read w where those read y
//   [K; b; c_q; c_r] = correction([m; w])             K row by row
//   x, P  by the measurement (nlo/covariance.h), with q = state_noise exp(c_q) and r = output_noise exp(c_r)
//   x  += K s(nu, coarse) + b
//   x_hat = T*([m; x; p])
// [x; p] is kept within [state_min, state_max]. z = [m; x; p], p: the upper triangle of P, row by row.
#pragma once

#include "codegen/model/equations.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

struct Prior {
  EquationTexts equations;
  Eigen::VectorXd state_min, state_max;       ///< of [x; p], a little beyond the states' range
  Eigen::VectorXd fine, coarse;               ///< n_y, innovations that s makes 1/2
  Eigen::VectorXd state_noise, output_noise;  ///< n_x of a sample period and n_y: variances where c_q and c_r are 0
  Network gates;                              ///< [m; w] -> [a_s; a_g]: one layer
  Network candidate;                          ///< [g m; w] -> n_m, before the tanh: one layer
  Network correction;                         ///< [m; w] -> n_x (n_y + 2) + n_y: one layer
  Network inverse_map;                        ///< T*: z or [z; y] -> x_hat
};

}  // namespace nlo::codegen
