// SPDX-License-Identifier: MIT
#include "trainer/prove/arithmetic_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <vector>

#include "trainer/prove/layer_range.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Bounds the error of the exported map over one box at a time.
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
    if (layers_.size() == 1) {  // a map of one layer includes the linear path
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
    const Vector middle_in = (inputs_ * box.centre).head(in.size());
    Vector low_in = middle_in - kRaised * (inputs_.cwiseAbs() * box.radius).head(in.size());  // input of a layer
    Vector high_in = 2.0 * middle_in - low_in, off = input_off_;                              // error of this input
    std::vector<Known> locals;
    std::vector<SlopeLine> slopes;
    for (std::size_t l = 0; l < ranges.size(); ++l) {
      const Known sum = sum_error(l, low_in, high_in);
      off = (kRaised * ((layers_[l].weights.cwiseAbs() + off_[l].weights) * off + sum.most())).eval();
      const Vector low = ranges[l].low - off, high = ranges[l].high + off;
      SlopeLine slope = slope_line(activation_, low, high, 0.5 * (low + high));
      const Vector steepest = slope.centre.cwiseAbs() + slope.range;
      activated_range(activation_, low, high, low_in, high_in);
      const Vector beyond = (high_in.array() - flown_.layers[l].largest).max(0.0);
      const Vector argument = low.cwiseAbs().cwiseMax(high.cwiseAbs());
      const Vector activation = (beyond + flown_.activation_relative * argument).array() + flown_.activation_off;
      locals.push_back({slope.centre.cwiseProduct(sum.middle),
                        kRaised * (steepest.cwiseProduct(sum.radius) + slope.range.cwiseProduct(sum.middle.cwiseAbs()) +
                                   activation)});
      off = (kRaised * (steepest.cwiseProduct(off) + activation)).eval();
      low_in -= activation;
      high_in += activation;
      slopes.push_back(std::move(slope));
    }
    const std::size_t last = layers_.size() - 1;
    const Vector out = layer_size(last, low_in.cwiseAbs().cwiseMax(high_in.cwiseAbs()));
    Known error = sum_error(last, low_in, high_in);
    error.radius += flown_.output_rounding * out + flown_.path_off * in +
                    flown_.path_rounding * (out + (path_.cwiseAbs() + flown_.path_off) * in);
    // The Jacobian of the network after a layer, computed from the last layer back to the inputs.
    Matrix tail = layers_[last].weights, around = off_[last].weights;
    for (std::size_t l = last; l-- > 0;) {
      error.middle += tail * locals[l].middle;
      error.radius += kRaised * (around * locals[l].middle.cwiseAbs() + (tail.cwiseAbs() + around) * locals[l].radius) +
                      kRounding * (tail.cwiseAbs() * locals[l].middle.cwiseAbs());
      const SlopeLine& slope = slopes[l];
      const Matrix weights = layers_[l].weights.cwiseAbs() + off_[l].weights;
      const Matrix middle = tail * slope.centre.asDiagonal();
      const Matrix spread =
          around * (slope.centre.cwiseAbs() + slope.range).asDiagonal() + tail.cwiseAbs() * slope.range.asDiagonal();
      around = kRaised * (spread * weights + middle.cwiseAbs() * (off_[l].weights + kRounding * weights));
      tail = middle * layers_[l].weights;
    }
    error.radius += kRaised * (((tail + path_).cwiseAbs() + around + path_off_) * input_off_);
    return {kRaised * error.most(), enclosure_.split_of(ranges, box)};
  }

 private:
  /// Bound of the rounding error of a sum in this class, relative to the sum of |terms|, with a few thousand terms.
  static constexpr double kRounding = 1e-11, kRaised = 1.0 + kRounding;
  static_assert(kRounding > gamma(40000));

  /// An error that is known to be within middle +- radius.
  struct Known {
    Vector middle, radius;

    Vector most() const { return middle.cwiseAbs() + radius; }
  };

  Vector layer_size(std::size_t l, const Vector& size) const {
    const FlownLayer& flown = flown_.layers[l];
    return (layers_[l].weights.cwiseAbs() + flown.known.weights.cwiseAbs() + flown.off.weights) * size +
           layers_[l].bias.cwiseAbs() + flown.known.bias.cwiseAbs() + flown.off.bias;
  }
  /// Bounds the error of the sums of layer l compared with the real layer, for exported inputs between `low` and
  /// `high`.
  Known sum_error(std::size_t l, const Vector& low, const Vector& high) const {
    const FlownLayer& layer = flown_.layers[l];
    const Vector middle = 0.5 * (low + high), size = low.cwiseAbs().cwiseMax(high.cwiseAbs());
    const Matrix known = layer.known.weights.cwiseAbs();
    return {
        layer.known.weights * middle + layer.known.bias,
        kRaised * (known * (0.5 * (high - low)) + layer.off.weights * size + layer.off.bias +
                   (layer.sum_rounding + kRounding) * (known * size + layer.known.bias.cwiseAbs()) +
                   layer.sum_rounding * layer_size(l, size) + Vector::Constant(layer.off.bias.size(), layer.sum_off))};
  }

  const codegen::ActivationRow& activation_;
  Matrix inputs_;
  const FlownMap& flown_;
  JacobianEnclosure enclosure_, real_;  ///< for p; for [z; y]
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
