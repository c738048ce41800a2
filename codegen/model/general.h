// SPDX-License-Identifier: MIT
// General observer (11): z' = F(z, y), x_hat = G(z). The linear path of F stabilises it; this is not proven.
#pragma once

#include "codegen/model/network.h"

namespace nlo::codegen {

struct General {
  Network dynamics;     ///< F: [z; y] -> dz/dt, n_z + n_y -> n_z
  Network inverse_map;  ///< G: z -> x_hat, n_z -> n_x
};

}  // namespace nlo::codegen
