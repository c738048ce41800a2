// SPDX-License-Identifier: MIT
// The reachable set of a KKL observer's latent state for any measurements. With z+ = A z + B0 y_k + B1 y_(k+1) and
// every y_j = c_j + r_j s, |s| <= 1, which validation guarantees,
//   z_k = A^k z_0 + B1 y_k + sum over 0 < m < k of A^(m-1) (B0 + A B1) y_(k-m) + A^(k-1) B0 y_0
// so coordinate i fills an interval whose half width is the sum of |row i of each factor| r, and no smaller interval
// contains it. An output that wraps is unwrapped together with z. For such an output a step moves z - S y by (S - B1)
// times a change of at most half a turn, and y itself is within half a turn.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"

namespace nlo::trainer {

/// Bounds of z at any sample after a reset; n_z each.
struct LatentHull {
  Eigen::VectorXd low, high;

  Eigen::VectorXd middle() const { return 0.5 * (low + high); }
};

/// Returns true if A, B0 and B1 alone determine how readings move z: the latent system is linear, and it has no other
/// input.
bool moves_linearly(const codegen::Model& model);

/// Bounds z for steps of one sample period, including rounding errors, with the exported A - I, B0 and B1 in double.
LatentHull reachable_latent(const codegen::Model& model);

/// Returns the extremes of z that the reference observer reaches with readings at their limits, chosen for each
/// coordinate. reachable_latent() must contain them.
LatentHull reached_latent(const codegen::Model& model);

}  // namespace nlo::trainer
