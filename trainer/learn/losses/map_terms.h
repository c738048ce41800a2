// SPDX-License-Identifier: MIT
// Losses of the map T at a block of samples, weighted, with their gradients; float for training, double for the tests.
#pragma once

#include "trainer/learn/losses/map_block.h"

namespace nlo::trainer {

/// weight sum_s w_s |z - T(x)|^2 after block.forward(). Adds dl/dT to the block and, with `cotangent_z` (n_z rows),
/// dl/dz there.
template <class Scalar, int kColumns>
double map_consistency(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight,
                       Scalar* cotangent_z);

/// weight sum_s w_s |x - T*(T(x))|^2 after block.forward(). With `cotangent_z`, which it leaves as it is, adds dl/dT
/// and the gradient of T*.
template <class Scalar, int kColumns>
double reconstruction(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight,
                      Scalar* cotangent_z);

/// weight sum_s w_s |dT/dx f(x) - D T(x) - F h(x)|^2 (5); its gradients when `backward`: second derivatives of T, by
/// forward mode along f(x), then reverse mode through both.
template <class Scalar, int kColumns>
double pde_residual(MapBlock<Scalar, kColumns>& block, const MapSamples<Scalar>& samples, double weight, bool backward);

}  // namespace nlo::trainer
