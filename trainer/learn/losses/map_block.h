// SPDX-License-Identifier: MIT
// T beside its inverse T* at a block of samples: evaluates the losses of T and propagates their cotangents back.
// Each map is a network between normalised values: T(x) = mean_z + scale_z n((x - mean_x) / scale_x).
#pragma once

#include <cstddef>
#include <vector>

#include "trainer/gradients/nn/network_block.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// The samples of a block: rows of NetworkBlock::kStride columns, of which the first `count` are used.
template <class Scalar>
struct MapSamples {
  int count = 0;
  const Scalar* x = nullptr;       ///< n_x rows
  const Scalar* z = nullptr;       ///< n_z rows
  const Scalar* y = nullptr;       ///< n_y rows, as measured; T* may read them
  const Scalar* f = nullptr;       ///< n_x rows, f(x), for the residual
  const Scalar* h = nullptr;       ///< n_y rows, h(x), for the residual
  const Scalar* weight = nullptr;  ///< one for each column
};

template <class Scalar, int kColumns>
class MapBlock {
 public:
  using Network = NetworkBlock<Scalar, kColumns>;
  static constexpr int kStride = Network::kStride;

  /// The structure must have a forward map and outlive this object. Its means and scales may still change.
  ///   with_tangents  true for losses of dT/dx
  MapBlock(const ObserverStructure& structure, bool normalised, bool with_tangents);

  /// Reads the parameters of T* and T and the eigenvalues of D (n_z). Call it once for each set of parameters.
  void prepare(const Scalar* inverse_map, const Scalar* forward_map, const std::vector<double>& eigenvalues);

  /// Computes latent() = T(x) and clears the cotangent of latent().
  void forward(const MapSamples<Scalar>& samples);
  /// Propagates the cotangent of latent() back through T.
  void backward(int count);

  /// Evaluates the network of T and its tangents along f(x), with normalised outputs. backward_tangents() reads the
  /// cotangents from tangent_network().
  void forward_tangents(const MapSamples<Scalar>& samples);
  void backward_tangents() { forward_.backward_tangents(forward_parameters_, forward_transposed_.data()); }
  Network& tangent_network() { return forward_; }

  /// Computes T* from latent() and the samples' y, with normalised outputs. pull_back_inverse() reads the cotangents
  /// from inverse_network() and adds to the cotangent of latent().
  void run_inverse(const MapSamples<Scalar>& samples);
  void pull_back_inverse(int count);
  Network& inverse_network() { return inverse_; }

  const ObserverStructure& structure() const { return *structure_; }
  const std::vector<double>& eigenvalues() const { return eigenvalues_; }
  Scalar* latent(std::size_t row) { return latent_.data() + row * kStride; }
  Scalar* latent_cotangent(std::size_t row) { return latent_cotangent_.data() + row * kStride; }
  double& eigenvalue_gradient(std::size_t row) { return eigenvalue_gradient_[row]; }
  /// Returns the factor of a squared error in z or x: 1, or 1 / scale^2 if errors are normalised.
  Scalar latent_share(std::size_t row) const { return share_of(structure_->latent_scale[row]); }
  Scalar state_share(std::size_t row) const { return share_of(structure_->state_scale[row]); }

  void clear_gradient();
  /// Writes the gradients with respect to T*, T and the eigenvalues (n_z, not their parameters).
  void gradient(Scalar* inverse_map, Scalar* forward_map, double* eigenvalues) const;

 private:
  Scalar share_of(float scale) const {
    return normalised_ ? Scalar(1) / (static_cast<Scalar>(scale) * static_cast<Scalar>(scale)) : Scalar(1);
  }
  void set_forward_input(const MapSamples<Scalar>& samples);

  const ObserverStructure* structure_;
  bool normalised_;
  Network forward_, inverse_;
  std::vector<Scalar> forward_transposed_, inverse_transposed_;
  const Scalar* forward_parameters_ = nullptr;
  const Scalar* inverse_parameters_ = nullptr;
  std::vector<double> eigenvalues_, eigenvalue_gradient_;
  std::vector<Scalar> latent_;            // T(x), n_z rows
  std::vector<Scalar> latent_cotangent_;  // dl/dT, n_z rows
};

}  // namespace nlo::trainer
