// SPDX-License-Identifier: MIT
// A network as codegen/model.h states it, over columns of inputs: nothing folded, Eigen's activations.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "codegen/model.h"

namespace nlo::codegen {

template <class Scalar>
class ReferenceNetwork {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// Copies the network, rounded to Scalar.
  explicit ReferenceNetwork(const Network& network)
      : activation_(network.activation),
        features_(network.features.cast<Scalar>()),
        skip_(network.skip.cast<Scalar>()),
        feature_mean_(network.feature_mean.cast<Scalar>()),
        feature_scale_(network.feature_scale.cast<Scalar>()),
        output_mean_(network.output_mean.cast<Scalar>()),
        output_scale_(network.output_scale.cast<Scalar>()) {
    for (const DenseLayer& layer : network.layers)
      layers_.push_back({layer.weights.cast<Scalar>(), layer.bias.cast<Scalar>()});
  }

  /// out (n_out x B) for each column of `in` (n_in x B).
  Matrix operator()(const Matrix& in) const {
    Matrix u = features_ * in;
    u = (u.colwise() - feature_mean_).array().colwise() / feature_scale_.array();
    Matrix a = u;
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      a = ((layers_[l].weights * a).colwise() + layers_[l].bias).eval();
      if (l + 1 < layers_.size()) activate(a);
    }
    if (skip_.size() != 0) a += skip_ * u;
    return (a.array().colwise() * output_scale_.array()).matrix().colwise() + output_mean_;
  }

 private:
  struct Layer {
    Matrix weights;
    Vector bias;
  };

  void activate(Matrix& v) const {
    if (activation_ == "tanh") {
      v = v.array().tanh();
    } else if (activation_ == "relu") {
      v = v.cwiseMax(Scalar(0));
    } else {  // silu
      v = v.array() / (Scalar(1) + (-v.array()).exp());
    }
  }

  std::string activation_;
  std::vector<Layer> layers_;
  Matrix features_, skip_;
  Vector feature_mean_, feature_scale_, output_mean_, output_scale_;
};

}  // namespace nlo::codegen
