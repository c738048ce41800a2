// SPDX-License-Identifier: MIT
// The layers of a JacobianEnclosure: folding, rounding, and their ranges over a box.
#include "trainer/prove/layer_range.h"

#include <utility>

#include "trainer/prove/jacobian_enclosure.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Bounds the rounding error of weights times a vector with entries of at most `size`, including the error of folding
/// the weights.
Vector times(const codegen::DenseLayer& rounding, const Vector& size) {
  return rounding.weights * size + rounding.bias;
}

}  // namespace

JacobianEnclosure::JacobianEnclosure(const codegen::Network& m, const Matrix& inputs, Matrix directions)
    : activation_(&codegen::activation_row(m.activation)), layers_(m.layers), directions_(std::move(directions)) {
  const Vector inverse_scale = m.feature_scale.cwiseInverse();
  const Matrix features = inverse_scale.asDiagonal() * m.features * inputs;
  linear_path_ = m.skip.size() != 0 ? Matrix(m.output_scale.asDiagonal() * m.skip * features)
                                    : Matrix(Matrix::Zero(m.output_scale.size(), inputs.cols()));
  std::vector<codegen::DenseLayer>& sizes = rounding_.layer = m.layers;
  double roundings = 16.0 + static_cast<double>(m.features.rows() + 2 * inputs.rows() + inputs.cols());
  for (codegen::DenseLayer& layer : sizes) {
    layer = {layer.weights.cwiseAbs(), layer.bias.cwiseAbs()};
    roundings += static_cast<double>(layer.weights.cols()) + 8.0;
  }
  rounding_.gamma = gamma(4.0 * roundings);  // several times the terms of one sum, because sums are nested
  const Matrix feature_sizes = inverse_scale.cwiseAbs().asDiagonal() * m.features.cwiseAbs() * inputs.cwiseAbs();
  sizes.front().bias += sizes.front().weights * m.feature_mean.cwiseProduct(inverse_scale).cwiseAbs();
  sizes.front().weights = (sizes.front().weights * feature_sizes).eval();
  sizes.back().weights = (m.output_scale.cwiseAbs().asDiagonal() * sizes.back().weights).eval();
  codegen::DenseLayer& first = layers_.front();
  first.bias -= first.weights * m.feature_mean.cwiseProduct(inverse_scale);
  first.weights = (first.weights * features).eval();
  layers_.back().weights = (m.output_scale.asDiagonal() * layers_.back().weights).eval();
  layers_.back().bias = (m.output_mean + m.output_scale.cwiseProduct(layers_.back().bias)).eval();
  sizes.back().bias = (m.output_mean.cwiseAbs() + m.output_scale.cwiseAbs().cwiseProduct(sizes.back().bias)).eval();
  if (m.skip.size() != 0) {
    const Vector at_zero = m.feature_mean.cwiseProduct(inverse_scale);
    layers_.back().bias -= m.output_scale.cwiseProduct(m.skip * at_zero);
    sizes.back().bias += m.output_scale.cwiseAbs().cwiseProduct(m.skip.cwiseAbs() * at_zero.cwiseAbs());
    rounding_.linear_path = m.output_scale.cwiseAbs().asDiagonal() * m.skip.cwiseAbs() * feature_sizes;
  } else {
    rounding_.linear_path = Matrix::Zero(linear_path_.rows(), linear_path_.cols());
  }
  for (std::size_t l = 0; l + 1 < layers_.size(); ++l) balance_.push_back(Vector::Ones(layers_[l].weights.rows()));

  const Matrix along = directions_.cwiseAbs();
  Matrix mid;
  for (std::size_t n = 0; n < sizes.size(); ++n) {
    mid = n == 0 ? sizes[0].weights : Matrix(kSteepest * (sizes[n].weights * mid));
    if (n + 1 == sizes.size()) mid += rounding_.linear_path;
    rounding_.mid.push_back(rounding_.gamma * mid);
    rounding_.mid_norm.push_back(frobenius_above(rounding_.mid.back() * along));
    auto& from = rounding_.from.emplace_back();
    auto& from_norm = rounding_.from_norm.emplace_back();
    for (std::size_t l = 0; l < n; ++l) {
      Matrix size = l + 1 == n ? Matrix(rounding_.gamma * sizes[n].weights)
                               : Matrix(kSteepest * (sizes[n].weights * rounding_.from[n - 1][l]));
      from_norm.push_back(frobenius_above(size));
      from.push_back(std::move(size));
    }
  }
  for (codegen::DenseLayer& layer : sizes) {
    layer.weights *= rounding_.gamma;
    layer.bias *= rounding_.gamma;
  }
  rounding_.linear_path *= rounding_.gamma;
}

std::vector<LayerRange> JacobianEnclosure::ranges_over(const InputBox& box, Matrix& mid, AffineValues* values) const {
  const Vector& r = box.radius;
  const double raised = 1.0 + rounding_.gamma;
  Vector a = box.centre, off = Vector::Zero(r.size());  // values of the previous layer at the centre, and their errors
  Vector a_low = box.centre - r, a_high = box.centre + r;
  // The same values as affine functions of p: a = middle + gradient (p - centre) +- error.
  Vector middle = box.centre, error = Vector::Zero(r.size());
  Matrix gradient = Matrix::Identity(r.size(), r.size());
  std::vector<LayerRange> ranges;
  Matrix rad;
  for (std::size_t m = 0;; ++m) {
    const auto& [weights, bias] = layers_[m];
    if (m == 0) {
      mid = weights;
      rad = rounding_.mid[0];
    } else {
      LayerRange& before = ranges.back();
      const Matrix stepped = weights * before.slope.centre.asDiagonal();
      mid = stepped * before.mid;
      before.back = weights;
      for (std::size_t l = 0; l + 1 < m; ++l) ranges[l].back = (stepped * ranges[l].back).eval();
      for (std::size_t l = 0; l < m; ++l) ranges[l].back_size = ranges[l].back.cwiseAbs() + rounding_.from[m][l];
      if (m + 1 == layers_.size()) break;
      rad = rounding_.mid[m];
      for (const LayerRange& range : ranges) rad += range.back_size * range.slope.range.asDiagonal() * range.most;
      rad *= raised;
    }
    if (m + 1 == layers_.size()) break;
    // Three bounds of the pre-activations: from the mean value theorem around the centre, from the ranges of the
    // previous layer, and from its affine functions. Each is widened by its rounding.
    LayerRange range;
    range.mid = mid;
    range.rad = rad;
    range.most = raised * (mid.cwiseAbs() + rad);
    const Matrix size = weights.cwiseAbs();
    const Vector swing_of_a = gradient.cwiseAbs() * r + error;
    const Vector rounding = times(
        rounding_.layer[m],
        a.cwiseAbs().cwiseMax(a_low.cwiseAbs()).cwiseMax(a_high.cwiseAbs()).cwiseMax(middle.cwiseAbs() + swing_of_a));
    off = (raised * (size * off) + rounding).eval();
    const Vector v = weights * a + bias, reach = raised * (range.most * r) + off;
    const Vector centre = weights * (0.5 * (a_low + a_high)) + bias;
    const Vector spread = raised * (size * (0.5 * (a_high - a_low))) + rounding;
    middle = (weights * middle + bias).eval();
    gradient = (weights * gradient).eval();
    error = (raised * (size * error) + rounding).eval();
    const Vector swing = raised * (gradient.cwiseAbs() * r + error);
    const Vector low = (v - reach).cwiseMax(centre - spread).cwiseMax(middle - swing).cwiseMin(v) - rounding;
    const Vector high = (v + reach).cwiseMin(centre + spread).cwiseMin(middle + swing).cwiseMax(v) + rounding;
    range.low = low;
    range.high = high;
    range.slope = slope_line(*activation_, low, high, v);
    range.slope.remainder += range.slope.gradient.cwiseAbs().cwiseProduct(off);  // the line is centred at the real v
    a = v.unaryExpr(activation_->value);
    off = (kSteepest * off + rounding_.gamma * a.cwiseAbs()).eval();
    activated_range(*activation_, low, high, a_low, a_high);
    const ActivationLine line = activation_line(*activation_, low, high);
    const Vector slope = line.gradient.cwiseAbs();
    error = (raised * (slope.cwiseProduct(error) + line.remainder) +
             rounding_.gamma * (slope.cwiseProduct(middle.cwiseAbs() + swing) + line.offset.cwiseAbs()))
                .eval();
    middle = (line.offset + line.gradient.cwiseProduct(middle)).eval();
    gradient = (line.gradient.asDiagonal() * gradient).eval();
    for (const LayerRange& other : ranges) range.from.push_back(other.back);
    ranges.push_back(std::move(range));
  }
  mid += linear_path_;
  if (values == nullptr) return ranges;
  const auto& [weights, bias] = layers_.back();
  const Matrix size = weights.cwiseAbs();
  const Vector reads = box.centre.cwiseAbs() + r, reach = gradient.cwiseAbs() * r + error;
  const Vector rounding =
      times(rounding_.layer.back(),
            a.cwiseAbs().cwiseMax(a_low.cwiseAbs()).cwiseMax(a_high.cwiseAbs()).cwiseMax(middle.cwiseAbs() + reach)) +
      rounding_.linear_path * reads;
  const Matrix path = linear_path_;
  values->at_centre = weights * a + bias + path * box.centre;
  values->off = raised * (size * off + rounding);
  values->middle = weights * middle + bias + path * box.centre;
  values->gradient = weights * gradient + path;
  values->error = raised * (size * error + rounding);
  values->interval = weights * (0.5 * (a_low + a_high)) + bias + path * box.centre;
  values->spread = raised * (size * (0.5 * (a_high - a_low)) + path.cwiseAbs() * r + rounding);
  return ranges;
}

}  // namespace nlo::trainer
