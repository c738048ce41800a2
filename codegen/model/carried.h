// SPDX-License-Identifier: MIT
// Carried observer: a KKL observer of vectors in the axes of a body that turns with the rate w, its three inputs,
//   z' = D z + F y - w x z,   x_hat = sum_k c_k z_k
// Outputs and states are vectors of three components, one behind the other. D and F are those of one component; the
// rows of z are the modes of the first component of the first output vector, then those of its second component.
#pragma once

#include "codegen/model/kkl.h"

namespace nlo::codegen {

inline constexpr int kAxes = 3;  ///< components of a vector

struct Carried {
  LinearLatent component;    ///< F is one column
  Network inverse_map;       ///< T*: [z; y] -> x_hat, the same sum for each component: no bias, no hidden layer
  bool unit_length = false;  ///< each vector of x_hat is then made as long as 1
};

}  // namespace nlo::codegen
