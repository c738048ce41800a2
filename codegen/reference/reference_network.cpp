// SPDX-License-Identifier: MIT
#include "codegen/reference/reference_network.h"

#include "codegen/model/activations.h"

namespace nlo::codegen {

template <class Scalar>
ReferenceNetwork<Scalar>::ReferenceNetwork(const Network& network, Activations activations)
    : activation_(network.activation),
      exact_(activations == Activations::kExact),
      features_(network.features.cast<Scalar>()),
      skip_(network.skip.cast<Scalar>()),
      fallback_rows_(network.fallback.rows.cast<Scalar>()),
      fallback_outputs_(network.fallback.outputs),
      feature_clocks_(network.feature_clocks),
      feature_mean_(network.feature_mean.cast<Scalar>()),
      feature_scale_(network.feature_scale.cast<Scalar>()),
      output_mean_(network.output_mean.cast<Scalar>()),
      output_scale_(network.output_scale.cast<Scalar>()),
      fallback_offset_(network.fallback.offset.cast<Scalar>()),
      fallback_reach_(network.fallback.reach.cast<Scalar>()) {
  for (const DenseLayer& layer : network.layers)
    layers_.push_back({layer.weights.cast<Scalar>(), layer.bias.cast<Scalar>()});
}

template <class Scalar>
auto ReferenceNetwork<Scalar>::operator()(const Matrix& in) const -> Matrix {
  const Matrix u = normalised(in);
  Matrix a = u;
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    a = ((layers_[l].weights * a).colwise() + layers_[l].bias).eval();
    if (l + 1 < layers_.size()) a = activated(a);
  }
  if (skip_.size() != 0) a += skip_ * u;
  Matrix out = (a.array().colwise() * output_scale_.array()).matrix().colwise() + output_mean_;
  fall_back(u, out);
  return out;
}

template <class Scalar>
void ReferenceNetwork<Scalar>::fall_back(const Matrix& u, Matrix& out) const {
  if (fallback_outputs_.empty()) return;
  const Matrix rows = (fallback_rows_ * u).colwise() + fallback_offset_;
  for (std::size_t f = 0; f < fallback_outputs_.size(); ++f) {
    const auto at = static_cast<Eigen::Index>(f);
    auto estimate = out.row(fallback_outputs_[f]).array();
    const Eigen::Array<Scalar, 1, Eigen::Dynamic> apart = estimate - rows.row(at).array();
    estimate = rows.row(at).array() + apart / (Scalar(1) + (apart / fallback_reach_(at)).square());
  }
}

template <class Scalar>
auto ReferenceNetwork<Scalar>::jvp(const Vector& in, const Matrix& directions) const -> Matrix {
  Matrix a = normalised(in);
  Matrix du = (features_ * directions).array().colwise() / feature_scale_.array();
  if (!feature_clocks_.empty()) {  // d(u c) = du c + u dc
    const Vector u = (features_ * in - feature_mean_).array() / feature_scale_.array();
    for (std::size_t f = 0; f < feature_clocks_.size(); ++f) {
      if (feature_clocks_[f] < 0) continue;
      const auto row = static_cast<Eigen::Index>(f);
      du.row(row) = du.row(row) * in(feature_clocks_[f]) + u(row) * directions.row(feature_clocks_[f]);
    }
  }
  Matrix da = du;
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Matrix v = layers_[l].weights * a + layers_[l].bias;
    da = (layers_[l].weights * da).eval();
    if (l + 1 == layers_.size()) break;
    a = activated(v);
    da.array().colwise() *=
        activation_slopes<Scalar>(activation_row(activation_).trained_as, v.array(), a.array()).col(0);
  }
  if (skip_.size() != 0) da += skip_ * du;
  return da.array().colwise() * output_scale_.array();
}

template <class Scalar>
auto ReferenceNetwork<Scalar>::last_hidden(const Matrix& in) const -> Matrix {
  Matrix a = normalised(in);
  for (std::size_t l = 0; l + 1 < layers_.size(); ++l)
    a = activated(((layers_[l].weights * a).colwise() + layers_[l].bias).eval());
  return a;
}

template <class Scalar>
std::vector<double> ReferenceNetwork<Scalar>::largest_activations(const Matrix& in) const {
  std::vector<double> largest;
  Matrix a = normalised(in);
  for (std::size_t l = 0; l + 1 < layers_.size(); ++l) {
    a = activated(((layers_[l].weights * a).colwise() + layers_[l].bias).eval());
    largest.push_back(static_cast<double>(a.cwiseAbs().maxCoeff()));
  }
  return largest;
}

template <class Scalar>
auto ReferenceNetwork<Scalar>::normalised(const Matrix& in) const -> Matrix {
  Matrix u = features_ * in;
  u = ((u.colwise() - feature_mean_).array().colwise() / feature_scale_.array()).matrix();
  multiply_by_clocks(u, in, feature_clocks_);
  return u;
}

template <class Scalar>
auto ReferenceNetwork<Scalar>::activated(const Matrix& v) const -> Matrix {
  if (exact_) return codegen::activated<Scalar>(activation_, v.array()).matrix();
  return with_activation(activation_, [&](auto kind) -> Matrix {
    return v.unaryExpr([](Scalar value) { return activate<decltype(kind)::value>(value); });
  });
}

template class ReferenceNetwork<float>;
template class ReferenceNetwork<double>;

}  // namespace nlo::codegen
