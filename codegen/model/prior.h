// SPDX-License-Identifier: MIT
// Observer with a prior: the plant's known equations f and h, corrected by gated units that are learned.
//   x-  = x one step on by x' = f(x, u), RK4          the prior
//   nu  = y - h(x-)                                   the innovation
//   w   = [s(nu, fine); s(nu, coarse); y; u; x-]      s(v, c) = v / (c + |v|), between -1 and 1
//   m   gated units (gated.h) that read w where those read y
//   x   = x- + K s(nu, coarse) + b                    [K; b] = correction([m; w]), K row by row
//   x_hat = T*([m; x])
// x- and x are kept within [state_min, state_max]. z = [m; x].
#pragma once

#include "codegen/model/equations.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

struct Prior {
  EquationTexts equations;
  Eigen::VectorXd state_min, state_max;  ///< n_x, a little beyond the states' range
  Eigen::VectorXd fine, coarse;          ///< n_y, innovations that s makes 1/2
  Network gates;                         ///< [m; w] -> [a_s; a_g]: one layer
  Network candidate;                     ///< [g m; w] -> n_m, before the tanh: one layer
  Network correction;                    ///< [m; w] -> n_x (n_y + 1): one layer
  Network inverse_map;                   ///< T*: z or [z; y] -> x_hat
};

}  // namespace nlo::codegen
