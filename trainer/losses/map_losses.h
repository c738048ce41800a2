// SPDX-License-Identifier: MIT
// Losses of the map T beside its inverse T*, at a block of samples, with their gradients:
//   map consistency  |z - T(x)|^2
//   reconstruction   |x - T*(T(x))|^2
//   PDE residual     |dT/dx f(x) - D T(x) - F h(x)|^2        (5)
// The residual's gradient takes second derivatives of T: forward mode along f(x), then reverse mode through both.
// Each map is a network between normalised values: T(x) = mean_z + scale_z n(( x - mean_x) / scale_x).
#pragma once

#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/nn/network_block.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Samples as a block holds them: rows of NetworkBlock::kStride columns, `count` of them in use.
template <class Scalar>
struct MapSamples {
  int count = 0;
  const Scalar* x = nullptr;       ///< n_x rows
  const Scalar* z = nullptr;       ///< n_z rows
  const Scalar* y = nullptr;       ///< n_y rows, as measured; T* may read them
  const Scalar* f = nullptr;       ///< n_x rows, f(x): for the residual
  const Scalar* h = nullptr;       ///< n_y rows, h(x): for the residual
  const Scalar* weight = nullptr;  ///< one for each column
};

template <class Scalar, int kColumns>
class MapLosses {
 public:
  using Block = NetworkBlock<Scalar, kColumns>;

  /// The structure must have a forward map and outlive this; its means and scales may still change.
  MapLosses(const ObserverStructure& structure, const LossConfig& config);

  /// Reads the parameters of T* and T and the eigenvalues of D (n_z): once for each set of parameters.
  void prepare(const Scalar* inverse_map, const Scalar* forward_map, const std::vector<double>& eigenvalues);

  /// Map consistency and reconstruction, weighted. With `cotangent_z` (n_z rows) also their gradients, dl/dz added
  /// there.
  double consistency(const MapSamples<Scalar>& samples, Scalar* cotangent_z);

  /// PDE residual, weighted; its gradients when `backward`.
  double residual(const MapSamples<Scalar>& samples, bool backward);

  void clear_gradient();
  /// Writes the gradients with respect to T*, T and the eigenvalues (n_z, not their parameters).
  void gradient(Scalar* inverse_map, Scalar* forward_map, double* eigenvalues) const;

 private:
  void set_forward_input(const MapSamples<Scalar>& samples);
  Scalar latent_share(std::size_t row) const;
  double reconstruct(const MapSamples<Scalar>& samples, bool backward);

  const ObserverStructure* structure_;
  const LossConfig* config_;
  Block forward_, inverse_;
  std::vector<Scalar> forward_transposed_, inverse_transposed_;
  const Scalar* forward_parameters_ = nullptr;
  const Scalar* inverse_parameters_ = nullptr;
  std::vector<double> eigenvalues_, eigenvalue_gradient_;
  std::vector<Scalar> latent_;            // T(x), n_z rows
  std::vector<Scalar> latent_cotangent_;  // dl/dT, n_z rows
};

}  // namespace nlo::trainer
