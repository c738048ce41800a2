// SPDX-License-Identifier: MIT
#include "trainer/bounds/lipschitz.h"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <vector>

#include "codegen/base/linear_algebra.h"
#include "codegen/model/domain.h"
#include "codegen/reference/network.h"
#include "trainer/bounds/activation_slope.h"

namespace nlo::trainer {
namespace {

/// Slopes in [centre - radius, centre + radius].
struct CentredRange {
  double centre, radius;
};

CentredRange slopes_anywhere(Activation activation) {
  constexpr double kFar = 1e3;
  const SlopeRange range = slope_range(codegen::activation_row(activation), -kFar, kFar);
  return {0.5 * (range.low + range.high), 0.5 * (range.high - range.low)};
}

/// The layers with what stands around them: first = W_1 diag(1/scale) features, last = diag(output scale) W_L.
struct Around {
  std::vector<Eigen::MatrixXd> layers;
  Eigen::MatrixXd linear_path;  ///< 0 x 0 when there is none
};

Around around(const codegen::Network& m, Eigen::Index first_input, Eigen::Index inputs) {
  const Eigen::MatrixXd features =
      m.feature_scale.cwiseInverse().asDiagonal() * m.features.middleCols(first_input, inputs);
  Around result;
  for (const codegen::DenseLayer& layer : m.layers) result.layers.push_back(layer.weights);
  result.layers.front() = (result.layers.front() * features).eval();
  result.layers.back() = (m.output_scale.asDiagonal() * result.layers.back()).eval();
  if (m.skip.size() != 0) result.linear_path = m.output_scale.asDiagonal() * m.skip * features;
  return result;
}

double upper_bound(const Around& map, const CentredRange& range) {
  // total(i): bound of all terms that start at the input and end with a break behind layer i (or at the output).
  const std::size_t count = map.layers.size();
  std::vector<double> total(count, 0.0);
  for (std::size_t start = 0; start < count; ++start) {
    const double before = start == 0 ? 1.0 : range.radius * total[start - 1];
    Eigen::MatrixXd product = map.layers[start];
    for (std::size_t end = start; end < count; ++end) {
      if (end > start) product = (range.centre * map.layers[end] * product).eval();
      const bool whole = start == 0 && end + 1 == count;
      // The linear path has no activation either: it adds to the unbroken term before norms are taken.
      total[end] +=
          before *
          spectral_norm(whole && map.linear_path.size() != 0 ? Eigen::MatrixXd(product + map.linear_path) : product);
    }
  }
  return total.back();
}

}  // namespace

double spectral_norm(const Eigen::MatrixXd& matrix) {
  if (matrix.size() == 0) return 0.0;
  return codegen::singular_values(matrix)(0);
}

LipschitzConstants lipschitz_upper(const codegen::Model& model) {
  const CentredRange range = slopes_anywhere(codegen::inverse_map(model)->activation);
  const Eigen::Index nz = model.nz(), ny = model.ny();
  LipschitzConstants result{upper_bound(around(*codegen::inverse_map(model), 0, nz), range), 0.0};
  if (!codegen::inverse_map(model)->features.rightCols(ny).isZero(0.0))
    result.output = upper_bound(around(*codegen::inverse_map(model), nz, ny), range);
  // Where z - S y is held at its reach, S y carries on: y acts through T*'s z too. Holding z itself stretches nothing.
  if (model.saturates()) result.output += result.latent * spectral_norm(codegen::LatentDomain(model).relative_gain());
  return result;
}

Eigen::MatrixXd inverse_map_jacobian(const codegen::Model& model, const Eigen::VectorXd& z, const Eigen::VectorXd& y) {
  const codegen::Network& map = *codegen::inverse_map(model);
  Eigen::VectorXd input(z.size() + y.size());
  input << z, y;
  const Eigen::MatrixXd directions = Eigen::MatrixXd::Identity(map.inputs(), map.inputs());
  return codegen::ReferenceNetwork<double>(map).jvp(input, directions);
}

LipschitzConstants lipschitz_sampled(const codegen::Model& model, const Eigen::MatrixXd& z, const Eigen::MatrixXd& y) {
  LipschitzConstants result;
  const bool reads_output = !codegen::inverse_map(model)->features.rightCols(model.ny()).isZero(0.0);
  for (Eigen::Index b = 0; b < z.cols(); ++b) {
    const Eigen::MatrixXd jacobian = inverse_map_jacobian(model, z.col(b), y.col(b));
    result.latent = std::max(result.latent, spectral_norm(jacobian.leftCols(model.nz())));
    if (reads_output) result.output = std::max(result.output, spectral_norm(jacobian.rightCols(model.ny())));
  }
  return result;
}

}  // namespace nlo::trainer
