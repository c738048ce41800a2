// SPDX-License-Identifier: MIT
// Evaluates a network (codegen/model/network.h) over columns of inputs, with nothing folded. Activations are those of
// the standard library, or of the runtime to measure their effect. All code except flight and training uses this
// forward pass.
#pragma once

#include <nlo/kernels/activation.h>
#include <Eigen/Core>
#include <vector>

#include "codegen/model/network.h"

namespace nlo::codegen {

enum class Activations { kExact, kRuntime };

template <class Scalar>
class ReferenceNetwork {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// Copies the network, rounded to Scalar. With the runtime's activations, kTanh5e6 and kTanh5e5 are its coarser tanh.
  explicit ReferenceNetwork(const Network& network, Activations activations = Activations::kExact);

  /// Returns out (n_out x B) for each column of `in` (n_in x B).
  Matrix operator()(const Matrix& in) const;

  /// Returns (d out / d in)(in) directions, n_out x D, for one column of inputs; directions: n_in x D. The network has
  /// no fallback.
  Matrix jvp(const Vector& in, const Matrix& directions) const;

  /// Returns the last hidden layer for each column of `in`, n_h x B. The network must have a hidden layer.
  Matrix last_hidden(const Matrix& in) const;

  /// Returns the largest |activation| of each hidden layer over the columns of `in`.
  std::vector<double> largest_activations(const Matrix& in) const;

 private:
  struct Layer {
    Matrix weights;
    Vector bias;
  };

  Matrix normalised(const Matrix& in) const;
  Matrix activated(const Matrix& v) const;
  /// Applies the fallback to `out`, n_out x N; u: normalised inputs, n_u x N.
  void fall_back(const Matrix& u, Matrix& out) const;

  Activation activation_;
  bool exact_;
  std::vector<Layer> layers_;
  Matrix features_, skip_, fallback_rows_;
  std::vector<int> fallback_outputs_;
  std::vector<int> feature_clocks_;
  Vector feature_mean_, feature_scale_, output_mean_, output_scale_, fallback_offset_, fallback_reach_;
};

// Compiled once, for speed, in reference_network.cpp.
extern template class ReferenceNetwork<float>;
extern template class ReferenceNetwork<double>;

}  // namespace nlo::codegen
