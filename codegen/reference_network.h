// SPDX-License-Identifier: MIT
// A network as codegen/model.h states it, over columns of inputs: nothing folded, the standard library's activations
// (or the runtime's, to see what they change).
#pragma once

#include <nlo/activation.h>
#include <Eigen/Core>
#include <string>
#include <vector>

#include "codegen/model.h"

namespace nlo::codegen {

enum class Activations { kExact, kRuntime };

template <class Scalar>
class ReferenceNetwork {
 public:
  using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  /// Copies the network, rounded to Scalar. With the runtime's activations, tanh5e6 and tanh5e5 are its coarser tanh.
  explicit ReferenceNetwork(const Network& network, Activations activations = Activations::kExact)
      : activation_(network.activation),
        exact_(activations == Activations::kExact),
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
    const Matrix u = normalised(in);
    Matrix a = u;
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      a = ((layers_[l].weights * a).colwise() + layers_[l].bias).eval();
      if (l + 1 < layers_.size()) a = activated(a);
    }
    if (skip_.size() != 0) a += skip_ * u;
    return (a.array().colwise() * output_scale_.array()).matrix().colwise() + output_mean_;
  }

  /// d out / d in (in) direction, for one column of each.
  Vector jvp(const Vector& in, const Vector& direction) const {
    Vector a = normalised(in);
    const Vector du = (features_ * direction).cwiseQuotient(feature_scale_);
    Vector da = du;
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      const Matrix v = layers_[l].weights * a + layers_[l].bias;
      da = (layers_[l].weights * da).eval();
      if (l + 1 == layers_.size()) break;
      a = activated(v);
      da.array() *= slope(v, a).array();
    }
    if (skip_.size() != 0) da += skip_ * du;
    return da.cwiseProduct(output_scale_);
  }

 private:
  struct Layer {
    Matrix weights;
    Vector bias;
  };

  Matrix normalised(const Matrix& in) const {
    const Matrix u = features_ * in;
    return (u.colwise() - feature_mean_).array().colwise() / feature_scale_.array();
  }

  Matrix activated(const Matrix& v) const {
    if (!exact_) return v.unaryExpr([this](Scalar value) { return runtime_activation(value); });
    if (activation_ == "tanh") return v.array().tanh();
    if (activation_ == "relu") return v.cwiseMax(Scalar(0));
    return v.array() / (Scalar(1) + (-v.array()).exp());  // silu
  }

  Scalar runtime_activation(Scalar v) const {
    if (activation_ == "tanh") return activate<Activation::kTanh>(v);
    if (activation_ == "tanh5e6") return activate<Activation::kTanh5e6>(v);
    if (activation_ == "tanh5e5") return activate<Activation::kTanh5e5>(v);
    return activation_ == "relu" ? activate<Activation::kRelu>(v) : activate<Activation::kSilu>(v);
  }

  /// da/dv, from v and a = activated(v).
  Matrix slope(const Matrix& v, const Matrix& a) const {
    if (activation_.starts_with("tanh")) return Scalar(1) - a.array().square();
    if (activation_ == "relu") return (v.array() > Scalar(0)).template cast<Scalar>();
    const Matrix s = Scalar(1) / (Scalar(1) + (-v.array()).exp());
    return s.array() + a.array() * (Scalar(1) - s.array());
  }

  std::string activation_;
  bool exact_;
  std::vector<Layer> layers_;
  Matrix features_, skip_;
  Vector feature_mean_, feature_scale_, output_mean_, output_scale_;
};

}  // namespace nlo::codegen
