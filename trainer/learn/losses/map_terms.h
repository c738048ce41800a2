// SPDX-License-Identifier: MIT
// Weighted losses of the map T at a block of samples, with their gradients: in float for training, in double for tests.
#pragma once

#include "trainer/learn/losses/map_block.h"

namespace nlo::trainer {

/// Returns weight sum_s w_s |z - T(x)|^2 after block.forward(). Adds dl/dT to the block and, if `cotangent_z` (n_z
/// rows) is given, dl/dz to it.
template <class Scalar, int kColumns>
double map_consistency(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight,
                       Scalar* cotangent_z);

/// Returns weight sum_s w_s |x - T*(T(x))|^2 after block.forward(). If `cotangent_z` is given, adds dl/dT and the
/// gradient of T*. `cotangent_z` itself does not change.
template <class Scalar, int kColumns>
double reconstruction(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight,
                      Scalar* cotangent_z);

/// Returns weight sum_s w_s |dT/dx f(x) - D T(x) - F h(x)|^2 (5). If `backward`, adds its gradients. They need second
/// derivatives of T: forward mode along f(x), then reverse mode through both.
template <class Scalar, int kColumns>
double pde_residual(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight, bool backward);

}  // namespace nlo::trainer
