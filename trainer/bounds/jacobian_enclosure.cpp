// SPDX-License-Identifier: MIT
#include "trainer/bounds/jacobian_enclosure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "codegen/base/linear_algebra.h"
#include "trainer/bounds/activation_slope.h"

namespace nlo::trainer {

/// What is known of a hidden layer over the box.
struct LayerRange {
  SlopeLine slope;                    ///< per neuron: centre, gradient, remainders
  Eigen::MatrixXd mid;                ///< V at the slopes C of the layers before, n x n_p
  Eigen::MatrixXd rad;                ///< |V(p) - mid| is at most this
  Eigen::MatrixXd most;               ///< |V(p)|
  Eigen::VectorXd half_width;         ///< of the pre-activations' range
  Eigen::MatrixXd back;               ///< A of the layer that is looked at
  std::vector<Eigen::MatrixXd> from;  ///< A of this layer, of each layer before it
};

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Largest singular value, by the smaller Gram matrix: the matrices here have a few rows or columns.
double norm_of(const Matrix& m) {
  const Matrix gram = m.rows() < m.cols() ? Matrix(m * m.transpose()) : Matrix(m.transpose() * m);
  if (gram.rows() == 1) return std::sqrt(gram(0, 0));
  if (gram.rows() == 2) {
    const double half = 0.5 * (gram(0, 0) - gram(1, 1));
    return std::sqrt(0.5 * (gram(0, 0) + gram(1, 1)) + std::hypot(half, gram(0, 1)));
  }
  return std::sqrt(std::max(0.0, codegen::largest_eigenvalue(gram)));
}

/// |J - J_C| by the norms of its factors. Each diagonal D - C stands between two of them, and any positive diagonal S
/// may, as S^-1 (D - C) S is the same: S balances what comes in at a neuron and what it does to the output.
///   balance  S of each layer
double bound_by_norms(const std::vector<LayerRange>& ranges, const Matrix& directions,
                      const std::vector<Vector>& balance) {
  std::vector<Vector> out;
  std::vector<double> sizes;  // of S R^1/2 V directions
  double sum = 0.0;
  for (std::size_t m = 0; m < ranges.size(); ++m) {
    const LayerRange& range = ranges[m];
    const Vector root = range.slope.range.cwiseSqrt(), in = root.cwiseProduct(balance[m]);
    double size = norm_of(in.asDiagonal() * range.mid * directions);
    for (std::size_t l = 0; l < m; ++l)
      size += norm_of(in.asDiagonal() * range.from[l] * out[l].asDiagonal()) * sizes[l];
    sizes.push_back(size);
    out.push_back(root.cwiseQuotient(balance[m]));
    sum += norm_of(range.back * out.back().asDiagonal()) * size;
  }
  return sum;
}

/// max |centre + sum of +-h_k|, h_k the columns' blocks: at a corner, as a norm is convex.
double largest_at_corners(const Matrix& centre, const std::vector<Matrix>& steps) {
  constexpr std::size_t kMostCorners = 10;
  if (steps.size() > kMostCorners) {
    double sum = norm_of(centre);
    for (const Matrix& step : steps) sum += norm_of(step);
    return sum;
  }
  double largest = 0.0;
  Matrix corner = centre;
  for (const Matrix& step : steps) corner -= step;
  largest = norm_of(corner);
  unsigned signs = 0;
  for (unsigned n = 1; n < 1u << steps.size(); ++n) {  // Gray code: one sign changes at a time
    const auto k = static_cast<std::size_t>(__builtin_ctz(n));
    signs ^= 1u << k;
    corner += (signs >> k & 1u) != 0 ? Matrix(2.0 * steps[k]) : Matrix(-2.0 * steps[k]);
    largest = std::max(largest, norm_of(corner));
  }
  return largest;
}

}  // namespace

JacobianEnclosure::JacobianEnclosure(const codegen::Network& m, const Matrix& inputs, Matrix directions)
    : activation_(&codegen::activation_row(m.activation)), layers_(m.layers), directions_(std::move(directions)) {
  const Vector inverse_scale = m.feature_scale.cwiseInverse();
  const Matrix features = inverse_scale.asDiagonal() * m.features * inputs;
  linear_path_ = m.skip.size() != 0 ? Matrix(m.output_scale.asDiagonal() * m.skip * features)
                                    : Matrix(Matrix::Zero(m.output_scale.size(), inputs.cols()));
  codegen::DenseLayer& first = layers_.front();
  first.bias -= first.weights * m.feature_mean.cwiseProduct(inverse_scale);
  first.weights = (first.weights * features).eval();
  layers_.back().weights = (m.output_scale.asDiagonal() * layers_.back().weights).eval();
  for (std::size_t l = 0; l + 1 < layers_.size(); ++l) balance_.push_back(Vector::Ones(layers_[l].weights.rows()));
}

void JacobianEnclosure::balance(const InputBox& box, int rounds) {
  constexpr double kLeast = 1e-3, kTiny = std::numeric_limits<double>::min();  // a neuron that does nothing
  Matrix mid;
  const std::vector<LayerRange> ranges = ranges_over(box, mid);
  balance_.clear();
  for (const LayerRange& range : ranges) {
    const Vector entering = (range.mid * directions_).rowwise().norm(), leaving = range.back.colwise().norm();
    balance_.push_back((leaving.array().max(kLeast * leaving.maxCoeff() + kTiny) /
                        entering.array().max(kLeast * entering.maxCoeff() + kTiny))
                           .pow(0.25));
  }
  double best = bound_by_norms(ranges, directions_, balance_), factor = 2.0;
  for (int round = 0; round < rounds; ++round, factor = std::sqrt(factor)) {
    for (Vector& of_layer : balance_) {
      for (double& s : of_layer) {
        for (const double by : {factor, 1.0 / factor}) {
          const double before = s;
          s *= by;
          const double bound = bound_by_norms(ranges, directions_, balance_);
          if (bound < best) {
            best = bound;
            break;
          }
          s = before;
        }
      }
    }
  }
}

double JacobianEnclosure::at(const Vector& p) const {
  Vector a = p;
  Matrix da = directions_;
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Vector v = layers_[l].weights * a + layers_[l].bias;
    da = (layers_[l].weights * da).eval();
    if (l + 1 == layers_.size()) break;
    a = v.unaryExpr(activation_->value);
    da = (v.unaryExpr(activation_->slope).asDiagonal() * da).eval();
  }
  return norm_of(da + linear_path_ * directions_);
}

double JacobianEnclosure::cost() const {
  double sum = 2e5;  // what small matrices take besides
  const auto n_p = static_cast<double>(directions_.rows());
  for (std::size_t m = 1; m < layers_.size(); ++m) {
    const auto block = static_cast<double>(layers_[m].weights.size());
    sum += block * n_p;
    constexpr double kEigenvalues = 10.0;  // of a symmetric matrix, n^3 and more
    for (std::size_t l = 0; l < m; ++l)
      sum += kEigenvalues * block * static_cast<double>(layers_[l].weights.rows()) +
             (l + 1 < m ? block : 0.0) * static_cast<double>(layers_[l].weights.rows()) +
             n_p * static_cast<double>(layers_[m].weights.rows() * layers_[l].weights.rows());
  }
  return sum;
}

std::vector<LayerRange> JacobianEnclosure::ranges_over(const InputBox& box, Matrix& mid) const {
  const Vector& r = box.radius;
  Vector a = box.centre;  // values of the layer before, at the centre
  Vector a_low = box.centre - r, a_high = box.centre + r;
  // The same as affine functions of p: a = middle + gradient (p - centre) +- error.
  Vector middle = box.centre, error = Vector::Zero(r.size());
  Matrix gradient = Matrix::Identity(r.size(), r.size());
  std::vector<LayerRange> ranges;
  Matrix rad;
  for (std::size_t m = 0;; ++m) {
    const auto& [weights, bias] = layers_[m];
    if (m == 0) {
      mid = weights;
      rad = Matrix::Zero(weights.rows(), weights.cols());
    } else {
      LayerRange& before = ranges.back();
      const Matrix stepped = weights * before.slope.centre.asDiagonal();
      mid = stepped * before.mid;
      before.back = weights;
      for (std::size_t l = 0; l + 1 < m; ++l) ranges[l].back = (stepped * ranges[l].back).eval();
      if (m + 1 == layers_.size()) break;
      rad = Matrix::Zero(mid.rows(), mid.cols());
      for (const LayerRange& range : ranges) rad += range.back.cwiseAbs() * range.slope.range.asDiagonal() * range.most;
    }
    if (m + 1 == layers_.size()) break;
    // The pre-activations: by the mean value theorem around the centre, by the ranges of the layer before, and by its
    // affine functions.
    LayerRange range;
    range.mid = mid;
    range.rad = rad;
    range.most = mid.cwiseAbs() + rad;
    const Vector v = weights * a + bias, reach = range.most * r;
    const Vector centre = weights * (0.5 * (a_low + a_high)) + bias;
    const Vector spread = weights.cwiseAbs() * (0.5 * (a_high - a_low));
    middle = (weights * middle + bias).eval();
    gradient = (weights * gradient).eval();
    error = (weights.cwiseAbs() * error).eval();
    const Vector swing = gradient.cwiseAbs() * r + error;
    const Vector low = (v - reach).cwiseMax(centre - spread).cwiseMax(middle - swing).cwiseMin(v);
    const Vector high = (v + reach).cwiseMin(centre + spread).cwiseMin(middle + swing).cwiseMax(v);
    range.half_width = 0.5 * (high - low);
    range.slope = slope_line(*activation_, low, high, v);
    a = v.unaryExpr(activation_->value);
    activated_range(*activation_, low, high, a_low, a_high);
    const ActivationLine line = activation_line(*activation_, low, high);
    middle = (line.offset + line.gradient.cwiseProduct(middle)).eval();
    gradient = (line.gradient.asDiagonal() * gradient).eval();
    error = (line.gradient.cwiseAbs().cwiseProduct(error) + line.remainder).eval();
    for (const LayerRange& other : ranges) range.from.push_back(other.back);
    ranges.push_back(std::move(range));
  }
  mid += linear_path_;
  return ranges;
}

JacobianEnclosure::Bound JacobianEnclosure::over(const InputBox& box) const {
  constexpr double kRounding = 1.0 + 1e-9;  // sums of doubles, not directed; some 1e5 units in the last place
  const Vector& r = box.radius;
  Matrix mid;
  const std::vector<LayerRange> ranges = ranges_over(box, mid);
  Matrix entries = Matrix::Zero(mid.rows(), mid.cols()), linear = entries;
  std::vector<Matrix> steps;
  const Matrix along = directions_.cwiseAbs();
  for (const LayerRange& range : ranges) {
    const Matrix back = range.back.cwiseAbs();
    const Vector s = range.slope.gradient.cwiseAbs();
    entries += back * range.slope.range.asDiagonal() * range.most;
    const Vector first = s.cwiseProduct(range.mid.cwiseAbs() * r);
    const Vector second = range.slope.remainder + s.cwiseProduct(range.rad * r);
    linear += back * (first.asDiagonal() * range.rad + second.asDiagonal() * range.most);
  }
  for (Eigen::Index k = 0; k < r.size(); ++k) {
    if (r(k) == 0.0) continue;
    Matrix step = Matrix::Zero(mid.rows(), directions_.cols());
    for (const LayerRange& range : ranges) {
      const Vector turn = r(k) * range.slope.gradient.cwiseProduct(range.mid.col(k));
      step += range.back * (turn.asDiagonal() * (range.mid * directions_));
    }
    steps.push_back(std::move(step));
  }
  const Matrix at_centre = mid * directions_, beside = entries * along;
  const double by_norms = norm_of(at_centre) + bound_by_norms(ranges, directions_, balance_);
  const double by_entries = std::min(norm_of(at_centre) + norm_of(beside), norm_of(at_centre.cwiseAbs() + beside));
  const double by_line = largest_at_corners(at_centre, steps) + norm_of(linear * along);

  // A split pays where an input moves pre-activations whose slopes vary and matter.
  Vector gain = Vector::Zero(r.size());
  for (const LayerRange& range : ranges) {
    const Vector influence = range.back.colwise().norm().transpose().cwiseProduct(range.most.rowwise().norm());
    const Vector slope_per_width =
        range.slope.range.cwiseQuotient(range.half_width.cwiseMax(std::numeric_limits<double>::min()));
    gain += range.mid.cwiseAbs().transpose() * influence.cwiseProduct(slope_per_width);
  }
  Bound bound{kRounding * std::min({by_norms, by_entries, by_line}), 0};
  gain.cwiseProduct(r).maxCoeff(&bound.split);
  return bound;
}

}  // namespace nlo::trainer
