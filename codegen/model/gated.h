// SPDX-License-Identifier: MIT
// Gated observer: (11) with dz/dt = rate (target - z), all learned, which cannot diverge (nlo/gated_observer.h).
//   [a_s; a_g] = gates([z; y]),  rate = softplus(2 a_s) / sample period,  g = (1 + tanh a_g) / 2
//   target = tanh(candidate([g z; y]))
#pragma once

#include "codegen/model/contraction.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

struct Gated {
  Network gates;        ///< [z; y] -> [a_s; a_g], n_z + n_r -> 2 n_z, one layer
  Network candidate;    ///< [g z; y] -> argument of the tanh, n_z, one layer
  Network inverse_map;  ///< T*: z or [z; y] -> x_hat
  Contraction contraction = {};
};

}  // namespace nlo::codegen
