// SPDX-License-Identifier: MIT
// KKL observer (16): z' = D z + F y, x_hat = T*(z) or T*(z, y). With known inputs, y is [y; u].
#pragma once

#include <Eigen/Core>
#include <vector>

#include "codegen/model/network.h"

namespace nlo::codegen {

/// z' = D z + F y. D is block diagonal: first `pairs` 2x2 blocks [[re, -im], [im, re]], then real eigenvalues. z starts
/// at the model's initial z. starts_steady adds S y_0 to it, where S = -D^-1 F is the steady state per unit of y.
struct LinearLatent {
  int pairs = 0;
  Eigen::VectorXd eigenvalues;       ///< n_z [1/s]: (re, im) of each pair, then the real ones
  Eigen::MatrixXd output_injection;  ///< F, n_z x n_r; the state of a zero row is a clock, exp(lambda t) z(0)
  bool starts_steady = false;        ///< warm start: the first output sets z to its steady state
  /// Rising indices of the outputs, other than angles, that T* reads only through z - S y. A constant that is added to
  /// such an output does not change the domain, and the output is not clamped (flown_ranges.h).
  std::vector<int> relative_outputs = {};
};

struct Kkl {
  LinearLatent latent;
  Network inverse_map;  ///< T*: [z; y] -> x_hat, n_z + n_r -> n_x
};

}  // namespace nlo::codegen
