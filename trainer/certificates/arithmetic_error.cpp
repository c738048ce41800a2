// SPDX-License-Identifier: MIT
#include "trainer/certificates/arithmetic_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "trainer/bounds/layer_range.h"
#include "trainer/bounds/rounding.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// The map and its flown form, over one box at a time.
class FlownEnclosure {
 public:
  FlownEnclosure(const codegen::Model& model, const MapRegion& region, const FlownMap& flown, const Vector& latent_off)
      : activation_(codegen::activation_row(codegen::inverse_map(model)->activation)),
        inputs_(region.inputs),
        flown_(flown),
        enclosure_(*codegen::inverse_map(model), region.inputs,
                   Matrix::Identity(region.inputs.rows(), region.inputs.rows())),
        real_(*codegen::inverse_map(model), Matrix::Identity(region.inputs.rows(), region.inputs.rows()),
              Matrix::Identity(region.inputs.rows(), region.inputs.rows())) {
    const Index reads = flown.input_off.size();
    layers_ = real_.layers();
    off_ = real_.layer_roundings();
    path_ = real_.linear_path().leftCols(reads);
    path_off_ = real_.linear_path_rounding().leftCols(reads);
    layers_[0].weights = layers_[0].weights.leftCols(reads).eval();
    off_[0].weights = off_[0].weights.leftCols(reads).eval();
    if (layers_.size() == 1) {  // it takes the path up
      layers_[0].weights += path_;
      off_[0].weights += path_off_;
      path_.setZero();
      path_off_.setZero();
    }
    input_off_ = flown.input_off;
    input_off_.head(latent_off.size()) += latent_off;
    Vector all = Vector::Zero(region.inputs.rows());
    all.head(reads) = input_off_;
    wider_ = kRaised * (region.inputs.cwiseAbs() * all);
  }

  struct Bound {
    Vector error;
    Index split;
  };

  Bound over(InputBox box) const {
    box.radius = kRaised * (box.radius + wider_);
    const std::vector<LayerRange> ranges = enclosure_.layers_over(box);
    const Vector reads = kRaised * (inputs_.cwiseAbs() * (box.centre.cwiseAbs() + box.radius));
    const Vector in = reads.head(input_off_.size());
    Vector size = in, off = input_off_;  // of what a layer reads: |it|, how far it is from the real one
    std::vector<Vector> locals;
    std::vector<SlopeLine> slopes;
    for (std::size_t l = 0; l < ranges.size(); ++l) {
      const Vector local = sum_error(l, size);
      off = (kRaised * ((layers_[l].weights.cwiseAbs() + off_[l].weights) * off + local)).eval();
      const Vector low = ranges[l].low - off, high = ranges[l].high + off;
      SlopeLine slope = slope_line(activation_, low, high, 0.5 * (low + high));
      const Vector steepest = slope.centre.cwiseAbs() + slope.range;
      Vector lowest, highest;
      activated_range(activation_, low, high, lowest, highest);
      const Vector beyond = (highest.array() - flown_.layers[l].largest).max(0.0);
      const Vector argument = low.cwiseAbs().cwiseMax(high.cwiseAbs());
      const Vector activation = (beyond + flown_.activation_relative * argument).array() + flown_.activation_off;
      locals.push_back(kRaised * (steepest.cwiseProduct(local) + activation));
      off = (kRaised * (steepest.cwiseProduct(off) + activation)).eval();
      size = lowest.cwiseAbs().cwiseMax(highest.cwiseAbs()) + activation;
      slopes.push_back(std::move(slope));
    }
    const std::size_t last = layers_.size() - 1;
    const Vector out = layer_size(last, size);
    Vector error = sum_error(last, size) + flown_.output_rounding * out + flown_.path_off * in +
                   flown_.path_rounding * (out + (path_.cwiseAbs() + flown_.path_off) * in);
    // The Jacobian of the net behind a layer, back to the inputs.
    Matrix tail = layers_[last].weights, around = off_[last].weights;
    for (std::size_t l = last; l-- > 0;) {
      error += kRaised * ((tail.cwiseAbs() + around) * locals[l]);
      const SlopeLine& slope = slopes[l];
      const Matrix weights = layers_[l].weights.cwiseAbs() + off_[l].weights;
      const Matrix middle = tail * slope.centre.asDiagonal();
      const Matrix spread =
          around * (slope.centre.cwiseAbs() + slope.range).asDiagonal() + tail.cwiseAbs() * slope.range.asDiagonal();
      const double rounding = gamma(4 * layers_[l].weights.rows() + 16);
      around = kRaised * (spread * weights + middle.cwiseAbs() * (off_[l].weights + rounding * weights));
      tail = middle * layers_[l].weights;
    }
    error += kRaised * (((tail + path_).cwiseAbs() + around + path_off_) * input_off_);
    return {kRaised * error, enclosure_.split_of(ranges, box)};
  }

 private:
  /// More than all roundings of the sums here, of a few thousand terms >= 0 at most.
  static constexpr double kRaised = 1.0 + 1e-11;
  static_assert(1e-11 > gamma(40000));

  Vector layer_size(std::size_t l, const Vector& size) const {
    const codegen::DenseLayer& off = flown_.layers[l].off;
    return (layers_[l].weights.cwiseAbs() + off.weights) * size + layers_[l].bias.cwiseAbs() + off.bias;
  }
  /// Of the sums of layer l, given flown inputs of that size, against the real layer's.
  Vector sum_error(std::size_t l, const Vector& size) const {
    const FlownLayer& layer = flown_.layers[l];
    return kRaised * (layer.off.weights * size + layer.off.bias + layer.sum_rounding * layer_size(l, size) +
                      Vector::Constant(layer.off.bias.size(), layer.sum_off));
  }

  const codegen::ActivationRow& activation_;
  Matrix inputs_;
  const FlownMap& flown_;
  JacobianEnclosure enclosure_, real_;  ///< of p; of [z; y]
  std::vector<codegen::DenseLayer> layers_, off_;
  Matrix path_, path_off_;
  Vector input_off_, wider_;
};

struct ErrorBox {
  double over_found;
  std::int64_t number;
  Index split;
  Vector error;
  InputBox box;

  bool operator<(const ErrorBox& other) const {
    return over_found != other.over_found ? over_found < other.over_found : number > other.number;
  }
};

}  // namespace

ArithmeticError arithmetic_error(const codegen::Model& model, const MapRegion& region, const FlownMap& flown,
                                 const Vector& latent_off, const Vector& found, std::int64_t boxes, double gap) {
  const FlownEnclosure enclosure(model, region, flown, latent_off);
  ArithmeticError result;
  std::priority_queue<ErrorBox> left;
  const Vector least = found.cwiseMax(std::numeric_limits<double>::min());
  const auto look_at = [&](const InputBox& box, const Vector* parent) {
    FlownEnclosure::Bound bound = enclosure.over(box);
    if (parent != nullptr) bound.error = bound.error.cwiseMin(*parent);
    const double over_found = bound.error.cwiseQuotient(least).maxCoeff();
    left.push({over_found, result.boxes++, bound.split, std::move(bound.error), box});
  };
  look_at(region.box, nullptr);
  while (left.top().over_found > 1.0 + gap && result.boxes + 2 <= boxes) {
    const ErrorBox widest = left.top();
    left.pop();
    for (const InputBox& half : halves(widest.box, widest.split)) look_at(half, &widest.error);
  }
  result.bound = Vector::Zero(model.nx());
  for (; !left.empty(); left.pop()) result.bound = result.bound.cwiseMax(left.top().error);
  return result;
}

}  // namespace nlo::trainer
