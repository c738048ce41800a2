// SPDX-License-Identifier: MIT
// Carried observer: a KKL observer of vectors in the axes of a body that rotates with the rate w, its three inputs:
//   z' = D z + F y - w x z,   x_hat = sum_k c_k z_k
// Outputs and states are vectors of three components, one after another. D and F act on one component. The rows
// of z are the modes of the first component of the first output vector, then those of its second component, and so on.
#pragma once

#include "codegen/model/kkl.h"

namespace nlo::codegen {

inline constexpr int kAxes = 3;  ///< components of a vector

struct Carried {
  LinearLatent component;    ///< F is one column
  Network inverse_map;       ///< T*: [z; y] -> x_hat: one layer without bias, the same for each component
  bool unit_length = false;  ///< scales each vector of x_hat to length 1
};

}  // namespace nlo::codegen
