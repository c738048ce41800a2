// SPDX-License-Identifier: MIT
#include "trainer/prove/flown_map.h"

#include <nlo/kernels/int16.h>

#include <algorithm>
#include <cmath>

#include "codegen/model/flown_ranges.h"
#include "codegen/model/latent_step.h"
#include "trainer/prove/proven_activation.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

constexpr double kOne = kernels::int16::kOne;
constexpr double kTanhUnit = 0x1p16;  // unit of tanh's argument
constexpr double kSubnormal = 1e-30;  // bounds the loss by floats below 2^-126 and by z below 2^-100

/// Returns the real layers for the first `inputs` inputs of T*. A network of one layer includes the linear path.
std::vector<codegen::DenseLayer> real_layers(const JacobianEnclosure& real, Index inputs) {
  std::vector<codegen::DenseLayer> layers = real.layers();
  if (layers.size() == 1) layers[0].weights += real.linear_path();
  layers[0].weights = layers[0].weights.leftCols(inputs).eval();
  return layers;
}
std::vector<codegen::DenseLayer> real_roundings(const JacobianEnclosure& real, Index inputs) {
  std::vector<codegen::DenseLayer> layers = real.layer_roundings();
  if (layers.size() == 1) layers[0].weights += real.linear_path_rounding();
  layers[0].weights = layers[0].weights.leftCols(inputs).eval();
  return layers;
}

/// Bounds the error of the computed difference a - b: its rounding error plus the error `off` of b.
Matrix besides(const Matrix& a, const Matrix& b, const Matrix& off) {
  return upward(2.0 * kUnit * (a.cwiseAbs() + b.cwiseAbs()) + off, 4);
}
/// Returns a bound of |a - b| that includes this error.
Matrix apart(const Matrix& a, const Matrix& b, const Matrix& off) {
  return upward((a - b).cwiseAbs() + besides(a, b, off), 2);
}

/// Compares an exported layer with the real layer, whose computed numbers have the error `off`.
FlownLayer compared(const codegen::DenseLayer& flown, const codegen::DenseLayer& real, const codegen::DenseLayer& off) {
  FlownLayer layer;
  layer.known = {flown.weights - real.weights, flown.bias - real.bias};
  layer.off = {besides(flown.weights, real.weights, off.weights), besides(flown.bias, real.bias, off.bias)};
  return layer;
}

Matrix in_float(const Matrix& values) {
  return values.cast<float>().cast<double>();
}

/// Returns the largest |(q + 1/2) / 32767 - tanh| of the table over all its arguments.
double table_error() {
  static const double largest = [] {
    constexpr std::int32_t kEnd = 1 << 19;  // 8 in Q16
    double most = 0.0;
    for (std::int32_t argument = -kEnd; argument < kEnd; ++argument) {
      const double value = (kernels::int16::tanh_q15(argument) + 0.5) / kOne;
      most = std::max(most, std::abs(value - std::tanh(argument / kTanhUnit)));
    }
    return upward(most + 8.0 * kLibraryUlps * kUnit, 2);
  }();
  return largest;
}

}  // namespace

double float_gamma(Index roundings) {
  const double sum = static_cast<double>(roundings) * kFloatUnit;
  return upward(sum / (1.0 - sum), 2);
}

FlownMap flown_in_float(const JacobianEnclosure& real, const codegen::FoldedNetwork& folded) {
  const Index inputs = folded.inputs();
  const std::vector<codegen::DenseLayer> layers = real_layers(real, inputs), off = real_roundings(real, inputs);
  FlownMap map;
  map.input_off = Vector::Zero(inputs);
  for (std::size_t l = 0; l < layers.size(); ++l) {
    FlownLayer layer =
        compared({in_float(folded.layers[l].weights), in_float(folded.layers[l].bias)}, layers[l], off[l]);
    layer.sum_rounding = float_gamma(layers[l].weights.cols() + 1);
    layer.sum_off = kSubnormal;
    map.layers.push_back(std::move(layer));
  }
  if (folded.linear_path.size() != 0) {
    map.path_off = apart(in_float(folded.linear_path), real.linear_path().leftCols(inputs),
                         real.linear_path_rounding().leftCols(inputs));
    map.path_rounding = float_gamma(inputs + 1);
  } else {
    map.path_off = Matrix::Zero(layers.back().weights.rows(), inputs);
  }
  if (folded.activation == Activation::kSilu) {  // v (1 + tanh(v / 2)) / 2, and the rounding of the product
    map.activation_relative = kProvenGate + 4.0 * kFloatUnit;
  } else if (is_tanh(folded.activation)) {
    map.activation_off = folded.activation == Activation::kTanh5e5   ? kProvenTanh5e5
                         : folded.activation == Activation::kTanh5e6 ? kProvenTanh5e6
                                                                     : kProvenTanh;
  }
  return map;
}

FlownMap flown_in_int16(const JacobianEnclosure& real, const codegen::QuantisedNetwork& network,
                        const std::vector<double>& largest, const Vector& low, const Vector& high) {
  constexpr double kMany = 64.0;
  const Index inputs = network.inputs();
  const std::vector<codegen::DenseLayer> layers = real_layers(real, inputs), off = real_roundings(real, inputs);
  const bool is_tanh_map = network.activation == Activation::kTanh;
  FlownMap map;
  // per_unit: the value of one integer step. offset: the value of the integer zero.
  Vector per_unit = network.gain.cast<double>().cwiseInverse(), offset = network.centre.cast<double>();
  map.input_off.resize(inputs);
  for (Index i = 0; i < inputs; ++i) {
    const double reach = std::max(high(i) - offset(i), offset(i) - low(i)), end = kOne * per_unit(i);
    // A difference and a product are rounded before the conversion to an integer. An input beyond its range is clamped
    // to the nearer end.
    map.input_off(i) = upward((kProvenInt16Input + 2.5 * kFloatUnit * kOne) * per_unit(i) + std::max(reach - end, 0.0) +
                                  4.0 * kUnit * (std::abs(low(i)) + std::abs(high(i))),
                              4);
  }
  for (std::size_t l = 0; l < layers.size(); ++l) {
    const codegen::QuantisedLayer& integers = network.layers[l];
    const bool last = l + 1 == layers.size();
    const double unit = is_tanh_map || last ? kTanhUnit : kOne / largest[l];
    const Index rows = integers.weights.rows();
    Vector scale(rows);  // scale of a sum
    for (Index o = 0; o < rows; ++o)
      scale(o) = last ? static_cast<double>(network.scale(o)) : std::ldexp(1.0 / unit, -integers.shift);
    const double half = last ? 0.0 : std::ldexp(0.5, integers.shift);
    const Matrix weights = scale.asDiagonal() * integers.weights.cast<double>() * per_unit.cwiseInverse().asDiagonal();
    const Vector bias = scale.cwiseProduct((integers.bias.cast<double>().array() - half).matrix()) - weights * offset;
    const Vector bias_size =
        scale.cwiseProduct(integers.bias.cast<double>().cwiseAbs() + Vector::Constant(rows, half)) +
        weights.cwiseAbs() * offset.cwiseAbs();
    const double rounding = gamma(kMany + static_cast<double>(inputs + weights.cols()));
    FlownLayer layer = compared({weights, bias}, layers[l],
                                {off[l].weights + rounding * weights.cwiseAbs(), off[l].bias + rounding * bias_size});
    if (last) {
      layer.sum_off = kSubnormal;
    } else {
      layer.sum_off = 0.5 / unit;  // the shift rounds down; half a unit in the bias centres this error
      if (!is_tanh_map) layer.largest = largest[l];
    }
    map.layers.push_back(std::move(layer));
    per_unit = Vector::Constant(rows, (is_tanh_map || last ? 1.0 : largest[l]) / kOne);
    offset = Vector::Constant(rows, is_tanh_map ? 0.5 / kOne : 0.0);
  }
  if (is_tanh_map)
    map.activation_off = upward(table_error() + (1.0 - std::tanh(8.0)) + 1e-9, 2);  // the table ends at +-8
  map.output_rounding = float_gamma(2);
  if (network.linear_path.size() != 0) {
    map.path_off = apart(network.linear_path.cast<double>(), real.linear_path().leftCols(inputs),
                         real.linear_path_rounding().leftCols(inputs));
    map.path_rounding = float_gamma(inputs + 1);
  } else {
    map.path_off = Matrix::Zero(layers.back().weights.rows(), inputs);
  }
  return map;
}

Vector float_latent_error(const codegen::Model& m, const Vector& low, const Vector& high) {
  // Error of a step's coefficients in double: Higham, Functions of Matrices, section 10.7.4 gives an error of 3 (1 +
  // |lambda h|) units for the method of nlo/latent.h. Both are negligible beside float's unit.
  constexpr double kCoefficients = 128.0 * kUnit;
  const codegen::LinearLatent& latent = *codegen::linear_latent(m);
  const codegen::StepMatrices step = codegen::latent_step(m, m.sample_period_s);
  const Vector z = low.cwiseAbs().cwiseMax(high.cwiseAbs());
  const codegen::FlownRanges kept = codegen::flown_ranges(m);
  const Vector y = kept.kept_min.cwiseAbs().cwiseMax(kept.kept_max.cwiseAbs());
  const Matrix gain = codegen::steady_gain(m);
  const double sums = float_gamma(2 * m.nr() + 4);
  const auto flown = [](double value) { return static_cast<double>(static_cast<float>(value)); };
  const auto lost = [&](double value) { return std::abs(flown(value) - value); };
  Vector error(m.nz());
  for (Index r = 0; r < m.nz();) {
    const Index rows = r < 2 * latent.pairs ? 2 : 1;
    const auto size_of = [&](const auto& part) { return part.segment(r, rows).norm(); };
    const double of_coefficients = kCoefficients * (1.0 + size_of(latent.eigenvalues) * m.sample_period_s);
    const double re = step.a_minus_1(r), im = rows == 2 ? step.a_minus_1(r + 1) : 0.0;
    const double a_size = std::abs(re) + std::abs(im);
    const double a_off = lost(re) + lost(im) + of_coefficients * a_size;
    const double factor = upward(std::hypot(1.0 + flown(re), flown(im)), 8);
    Vector pushes = Vector::Zero(rows), push_off = pushes;
    double start = 0.0;
    for (Index j = 0; j < m.nr(); ++j) {
      const double all = size_of(step.b0.col(j)) + size_of(step.b1.col(j));
      for (Index i = 0; i < rows; ++i) {
        pushes(i) += (std::abs(step.b0(r + i, j)) + std::abs(step.b1(r + i, j))) * y(j);
        push_off(i) += (lost(step.b0(r + i, j)) + lost(step.b1(r + i, j)) + of_coefficients * all) * y(j);
        if (latent.starts_steady)
          start +=
              (lost(gain(r + i, j)) + kCoefficients * size_of(gain.col(j)) + sums * std::abs(gain(r + i, j))) * y(j);
      }
    }
    for (Index i = 0; i < rows; ++i)
      start += lost(m.initial_latent(r + i)) + (latent.starts_steady ? sums * std::abs(m.initial_latent(r + i)) : 0.0);
    const double size = size_of(z);
    // Bounds the error of z after any number of steps, given that the error before each step is at most `by`.
    const auto settled = [&](double by) {
      const Vector local = kFloatUnit * (z.segment(r, rows).array() + by) + (kSubnormal + a_off * size) +
                           sums * (a_size * (size + by) + pushes.array()) + push_off.array();
      return upward(std::max(start, local.norm() / (1.0 - factor)), 8 * m.nr() + 64);
    };
    double by = factor < 1.0 ? settled(0.0) : std::numeric_limits<double>::infinity();
    for (int i = 0; i < 50 && std::isfinite(by) && settled(by) > by; ++i) by = 1.01 * settled(by);
    if (!(settled(by) <= by)) by = std::numeric_limits<double>::infinity();
    error.segment(r, rows).setConstant(by);
    r += rows;
  }
  return error;
}

}  // namespace nlo::trainer
