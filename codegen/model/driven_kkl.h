// SPDX-License-Identifier: MIT
// Driven KKL observer (24)-(25) of dx/dt = f(x) + g(x) u with known inputs u:
//   z' = D z + F y + phi(z) u,   phi(z) u = dT/dx(x_hat) g(x_hat) u,   x_hat = T*(z)
#pragma once

#include <nlo/latent.h>
#include <vector>

#include "codegen/model/kkl.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

struct DrivenKkl : Kkl {
  std::vector<Channel> inputs;
  /// Zero order: u has acted since the last sample (a command). First order: a ramp from the last u to this one
  /// (measured with y).
  Hold input_hold = Hold::kZeroOrder;
  /// g = reshape(W x + b), with n_x n_u rows: the columns of g one after another. It is affine in x, which is exact for
  /// constant and bilinear inputs.
  DenseLayer input_field;
  Network forward_map;  ///< T, n_x -> n_z
};

}  // namespace nlo::codegen
