// SPDX-License-Identifier: MIT
#include "trainer/prove/jacobian_enclosure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "trainer/prove/layer_range.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {

namespace {

using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Bounds |centre + sum of s_k h_k| for all |s_k| <= 1, where h_k are the `steps`. A norm is convex, so it is largest
/// at a corner. If there are many steps, corners are tried for the largest ones only, and the norms of the others are
/// added.
double largest_at_corners(const Matrix& centre, std::vector<Matrix> steps) {
  constexpr std::size_t kMostCorners = 10;
  std::vector<double> sizes;
  for (const Matrix& step : steps) sizes.push_back(frobenius_above(step));
  double all = frobenius_above(centre), rest = 0.0;
  for (const double size : sizes) all += size;
  while (steps.size() > kMostCorners) {
    const auto least = std::min_element(sizes.begin(), sizes.end()) - sizes.begin();
    rest += norm_above(steps[static_cast<std::size_t>(least)]);
    sizes.erase(sizes.begin() + least);
    steps.erase(steps.begin() + least);
  }
  Matrix corner = centre;
  for (const Matrix& step : steps) corner -= step;
  double largest = norm_above(corner);
  unsigned signs = 0;
  for (unsigned n = 1; n < 1u << steps.size(); ++n) {  // Gray code: one sign changes at a time
    const auto k = static_cast<std::size_t>(__builtin_ctz(n));
    signs ^= 1u << k;
    corner += ((signs >> k & 1u) != 0 ? 2.0 : -2.0) * steps[k];
    largest = norm_above(corner, largest);
  }
  const double sums = std::exp2(static_cast<double>(steps.size())) + 16.0;
  return upward(largest + rest + gamma(2.0 * sums) * all, 64);
}

}  // namespace

void JacobianEnclosure::balance(const InputBox& box, int rounds) {
  // Limits the scale of neurons without effect.
  constexpr double kLeast = 1e-3, kTiny = std::numeric_limits<double>::min();
  Matrix mid;
  const std::vector<LayerRange> ranges = ranges_over(box, mid);
  balance_.clear();
  for (const LayerRange& range : ranges) {
    const Vector entering = (range.mid * directions_).rowwise().norm(), leaving = range.back.colwise().norm();
    balance_.push_back((leaving.array().max(kLeast * leaving.maxCoeff() + kTiny) /
                        entering.array().max(kLeast * entering.maxCoeff() + kTiny))
                           .pow(0.25));
  }
  double best = bound_by_norms(ranges), factor = 2.0;
  for (int round = 0; round < rounds; ++round, factor = std::sqrt(factor)) {
    for (Vector& of_layer : balance_) {
      for (double& s : of_layer) {
        for (const double by : {factor, 1.0 / factor}) {
          const double before = s;
          s *= by;
          const double bound = bound_by_norms(ranges);
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

// Bounds |J - J_C| by the norms of its factors. Each diagonal D - C stands between two factors. Since S^-1 (D - C) S =
// D - C for any positive diagonal S, the factors may be scaled by S and S^-1. This S, the balance, weighs the inputs of
// a neuron against its effect on the output.
double JacobianEnclosure::bound_by_norms(const std::vector<LayerRange>& ranges) const {
  std::vector<Vector> out;
  std::vector<double> sizes;  // bounds of |S R^1/2 V directions|
  double sum = 0.0;
  for (std::size_t m = 0; m < ranges.size(); ++m) {
    const LayerRange& range = ranges[m];
    const Vector root = range.slope.range.cwiseSqrt(), in = root.cwiseProduct(balance_[m]);
    double size = rough_norm_above(in.asDiagonal() * range.mid * directions_) + in.maxCoeff() * rounding_.mid_norm[m];
    for (std::size_t l = 0; l < m; ++l)
      size += (rough_norm_above(in.asDiagonal() * range.from[l] * out[l].asDiagonal()) +
               in.maxCoeff() * out[l].maxCoeff() * rounding_.from_norm[m][l]) *
              sizes[l];
    sizes.push_back(size);
    out.push_back(root.cwiseQuotient(balance_[m]));
    sum += (rough_norm_above(range.back * out.back().asDiagonal()) +
            out.back().maxCoeff() * rounding_.from_norm.back()[m]) *
           size;
  }
  return sum * (1.0 + rounding_.gamma);
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
  return norm_above(da + linear_path_ * directions_);
}

double JacobianEnclosure::cost() const {
  double sum = 2e5;  // overhead of small matrices, in multiply-adds
  const auto n_p = static_cast<double>(directions_.rows());
  for (std::size_t m = 1; m < layers_.size(); ++m) {
    const auto block = static_cast<double>(layers_[m].weights.size());
    sum += block * n_p;
    constexpr double kEigenvalues = 10.0;  // operations for a symmetric matrix, in n^3
    for (std::size_t l = 0; l < m; ++l)
      sum += kEigenvalues * block * static_cast<double>(layers_[l].weights.rows()) +
             (l + 1 < m ? block : 0.0) * static_cast<double>(layers_[l].weights.rows()) +
             n_p * static_cast<double>(layers_[m].weights.rows() * layers_[l].weights.rows());
  }
  return sum;
}

/// Two enclosures of J directions: at_centre +- entries, and at_centre + sum of steps_k (p - c)_k / r_k +- linear.
/// Neither includes the rounding of at_centre.
struct JacobianEnclosure::Pieces {
  std::vector<LayerRange> ranges;
  Matrix at_centre, entries, linear;
  std::vector<Matrix> steps;
};

JacobianEnclosure::Pieces JacobianEnclosure::pieces_over(const InputBox& box) const {
  const Vector& r = box.radius;
  Matrix mid;
  Pieces pieces{ranges_over(box, mid), {}, {}, {}, {}};
  const std::vector<LayerRange>& ranges = pieces.ranges;
  Matrix entries = Matrix::Zero(mid.rows(), mid.cols()), linear = entries;
  const Matrix along = directions_.cwiseAbs();
  for (std::size_t l = 0; l < ranges.size(); ++l) {
    const LayerRange& range = ranges[l];
    const Vector s = range.slope.gradient.cwiseAbs();
    entries += range.back_size * range.slope.range.asDiagonal() * range.most;
    const Vector first = s.cwiseProduct(range.mid.cwiseAbs() * r);
    const Vector second = range.slope.remainder + s.cwiseProduct(range.rad * r);
    linear += range.back_size * (first.asDiagonal() * range.rad + second.asDiagonal() * range.most);
    // Rounding errors of `steps` below: from A, and from the sum.
    linear += (rounding_.from.back()[l] + rounding_.gamma * range.back_size) * (first.asDiagonal() * range.most);
  }
  for (Eigen::Index k = 0; k < r.size(); ++k) {
    if (r(k) == 0.0) continue;
    Matrix step = Matrix::Zero(mid.rows(), directions_.cols());
    for (const LayerRange& range : ranges) {
      const Vector turn = r(k) * range.slope.gradient.cwiseProduct(range.mid.col(k));
      step += range.back * (turn.asDiagonal() * (range.mid * directions_));
    }
    pieces.steps.push_back(std::move(step));
  }
  const double raised = 1.0 + rounding_.gamma;
  pieces.at_centre = mid * directions_;
  pieces.entries = raised * (entries * along);
  pieces.linear = raised * (linear * along);
  return pieces;
}

JacobianEnclosure::Secants JacobianEnclosure::secants_over(const InputBox& box) const {
  Pieces pieces = pieces_over(box);
  // On the way from c to p, a step counts half on average: it grows from zero at c to a whole step at p.
  for (const Matrix& step : pieces.steps) pieces.linear += 0.5 * step.cwiseAbs();
  const double raised = 1.0 + rounding_.gamma;
  return {pieces.at_centre,
          raised * (pieces.entries.cwiseMin(pieces.linear) + rounding_.mid.back() * directions_.cwiseAbs())};
}

JacobianEnclosure::Bound JacobianEnclosure::over(const InputBox& box, bool norms) const {
  auto [ranges, at_centre, beside, linear, steps] = pieces_over(box);
  const double raised = 1.0 + rounding_.gamma, centre = norm_above(at_centre);
  const double by_entries = std::min(centre + norm_above(beside), norm_above(raised * (at_centre.cwiseAbs() + beside)));
  const double by_line = largest_at_corners(at_centre, std::move(steps)) + norm_above(linear);
  double least = std::min(by_entries, by_line);
  const double by_norms = norms ? centre + bound_by_norms(ranges) : least;
  norms = by_norms < least;
  least = std::min(by_norms, least);

  return {raised * (least + rounding_.mid_norm.back()), split_of(ranges, box), norms};
}

// Selects the input with the largest effect on pre-activations whose slopes vary and affect the output.
Eigen::Index JacobianEnclosure::split_of(const std::vector<LayerRange>& ranges, const InputBox& box) const {
  const Vector& r = box.radius;
  Vector gain = Vector::Zero(r.size());
  for (const LayerRange& range : ranges) {
    const Vector influence = range.back.colwise().norm().transpose().cwiseProduct(range.most.rowwise().norm());
    const Vector slope_per_width =
        range.slope.range.cwiseQuotient((0.5 * (range.high - range.low)).cwiseMax(std::numeric_limits<double>::min()));
    gain += range.mid.cwiseAbs().transpose() * influence.cwiseProduct(slope_per_width);
  }
  Eigen::Index best = 0;
  gain.cwiseProduct(r).maxCoeff(&best);
  return best;
}

std::vector<LayerRange> JacobianEnclosure::layers_over(const InputBox& box) const {
  Matrix mid;
  return ranges_over(box, mid);
}

JacobianEnclosure::Values JacobianEnclosure::values_over(const InputBox& box) const {
  const double raised = 1.0 + rounding_.gamma;
  Matrix mid;
  AffineValues v;
  const std::vector<LayerRange> ranges = ranges_over(box, mid, &v);
  Matrix most = mid.cwiseAbs() + rounding_.mid.back();  // largest entries of the Jacobian
  for (const LayerRange& range : ranges) most += range.back_size * range.slope.range.asDiagonal() * range.most;
  const Vector swing = raised * (v.gradient.cwiseAbs() * box.radius + v.error);
  const Vector reach = raised * (raised * (most * box.radius) + v.off);
  const auto widened = [&](const Vector& at, const Vector& by) { return Vector(by + rounding_.gamma * at.cwiseAbs()); };
  const Vector by_centre = widened(v.at_centre, reach), by_line = widened(v.middle, swing),
               by_range = widened(v.interval, v.spread);
  return {(v.at_centre - by_centre).cwiseMax(v.middle - by_line).cwiseMax(v.interval - by_range),
          (v.at_centre + by_centre).cwiseMin(v.middle + by_line).cwiseMin(v.interval + by_range),
          split_of(ranges, box)};
}

}  // namespace nlo::trainer
