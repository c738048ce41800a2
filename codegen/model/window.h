// SPDX-License-Identifier: MIT
// Window observer: the latent state is the window of the last n measurements, newest first, one output after the other:
//   z = [y_j(k), ..., y_j(k - n + 1)] for each output j and each known input,   x_hat = T*(z)
#pragma once

#include "codegen/model/network.h"

namespace nlo::codegen {

struct Window {
  int samples = 1;      ///< n
  Network inverse_map;  ///< T*: z -> x_hat, n_r n -> n_x
};

}  // namespace nlo::codegen
