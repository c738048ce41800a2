// SPDX-License-Identifier: MIT
// The global Lipschitz constant of T*, from its weights.
#include <algorithm>
#include <cmath>
#include <vector>

#include "codegen/model/domain.h"
#include "trainer/prove/activation_slope.h"
#include "trainer/prove/lipschitz.h"
#include "trainer/prove/map_region.h"
#include "trainer/prove/rounding.h"

namespace nlo::trainer {
namespace {

/// Slopes in [centre - radius, centre + radius].
struct CentredRange {
  double centre, radius;
};

CentredRange slopes_anywhere(Activation activation) {
  constexpr double kFar = 1e3;
  const SlopeRange range = slope_range(codegen::activation_row(activation), -kFar, kFar);
  const double centre = 0.5 * (range.low + range.high);
  return {centre, upward(std::max(range.high - centre, centre - range.low), 1)};
}

/// The layers and the matrices around them: first = W_1 diag(1/scale) features, last = diag(output scale) W_L.
struct Around {
  std::vector<Eigen::MatrixXd> layers;
  Eigen::MatrixXd linear_path;  ///< zeros when there is none
};

Around around(const codegen::Network& m, Eigen::Index first_input, Eigen::Index inputs) {
  const Eigen::MatrixXd features =
      m.feature_scale.cwiseInverse().asDiagonal() * m.features.middleCols(first_input, inputs);
  Around result;
  for (const codegen::DenseLayer& layer : m.layers) result.layers.push_back(layer.weights);
  result.layers.front() = (result.layers.front() * features).eval();
  result.layers.back() = (m.output_scale.asDiagonal() * result.layers.back()).eval();
  result.linear_path = Eigen::MatrixXd::Zero(m.output_scale.size(), inputs);
  if (m.skip.size() != 0) result.linear_path = m.output_scale.asDiagonal() * m.skip * features;
  return result;
}

/// Returns the layers and the matrices around them with the absolute values of all numbers.
Around sizes_around(codegen::Network m, Eigen::Index first_input, Eigen::Index inputs) {
  for (Eigen::MatrixXd* matrix : {&m.features, &m.skip}) *matrix = matrix->cwiseAbs();
  for (Eigen::VectorXd* vector : {&m.feature_scale, &m.output_scale}) *vector = vector->cwiseAbs();
  for (codegen::DenseLayer& layer : m.layers) layer.weights = layer.weights.cwiseAbs();
  return around(m, first_input, inputs);
}

double upper_bound(const Around& map, const Around& sizes, const CentredRange& range) {
  // total(i): bound of the sum of all terms from the input to a break after layer i (or to the output).
  const std::size_t count = map.layers.size();
  double roundings = 16.0;
  for (const Eigen::MatrixXd& layer : map.layers) roundings += static_cast<double>(layer.rows() + layer.cols());
  const double size = std::abs(range.centre) + range.radius;
  std::vector<double> total(count, 0.0);
  for (std::size_t start = 0; start < count; ++start) {
    const double before = start == 0 ? 1.0 : range.radius * total[start - 1];
    Eigen::MatrixXd product = map.layers[start], all = sizes.layers[start];
    for (std::size_t end = start; end < count; ++end) {
      if (end > start) {
        product = (range.centre * map.layers[end] * product).eval();
        all = (size * sizes.layers[end] * all).eval();
      }
      // The linear path has no activation either, so it is added to the unbroken term before the norm.
      const bool whole = start == 0 && end + 1 == count;
      const double norm = whole ? norm_above(product + map.linear_path) : norm_above(product);
      const double off = gamma(4.0 * roundings) * frobenius_above(whole ? all + sizes.linear_path : all);
      total[end] += before * (norm + off);
    }
  }
  return upward(total.back(), 8 * count * count);
}

double upper_bound(const codegen::Network& m, Eigen::Index first_input, Eigen::Index inputs,
                   const CentredRange& range) {
  return upper_bound(around(m, first_input, inputs), sizes_around(m, first_input, inputs), range);
}

}  // namespace

LipschitzConstants lipschitz_upper(const codegen::Model& model) {
  const CentredRange range = slopes_anywhere(codegen::inverse_map(model)->activation);
  const Eigen::Index nz = model.nz(), nr = readings_of_map(model);
  LipschitzConstants result{upper_bound(*codegen::inverse_map(model), 0, nz, range), 0.0};
  if (!codegen::inverse_map(model)->features.rightCols(nr).isZero(0.0))
    result.output = upper_bound(*codegen::inverse_map(model), nz, nr, range);
  // If z - S y is saturated, S y is not, so y also acts through z. Saturating z itself increases no slope.
  if (model.saturates())
    result.output = upward(result.output + result.latent * norm_above(codegen::LatentDomain(model).relative_gain()), 2);
  return result;
}

}  // namespace nlo::trainer
