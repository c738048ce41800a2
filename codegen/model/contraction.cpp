// SPDX-License-Identifier: MIT
#include "codegen/model/contraction.h"

#include <algorithm>
#include <cmath>

#include "codegen/model/model.h"

namespace nlo::codegen {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A network of one layer with its normalisation, as out = weights in + bias.
struct Affine {
  MatrixXd weights;
  VectorXd bias;

  explicit Affine(const Network& n) {
    const MatrixXd scaled =
        n.output_scale.asDiagonal() * n.layers[0].weights * n.feature_scale.cwiseInverse().asDiagonal();
    weights = scaled * n.features;
    bias = n.output_mean + n.output_scale.cwiseProduct(n.layers[0].bias) - scaled * n.feature_mean;
  }
};

}  // namespace

MatrixXd coupling(const Gated& gated, Index units) {
  const MatrixXd gates = Affine(gated.gates).weights.leftCols(units).cwiseAbs();
  const MatrixXd candidate = Affine(gated.candidate).weights.leftCols(units).cwiseAbs();
  return 4.0 * gates.topRows(units) + candidate * (MatrixXd::Identity(units, units) + 0.5 * gates.bottomRows(units));
}

double proven_rate(const Model& model, const Gated& gated, const VectorXd& metric) {
  const Index units = model.nz();
  if (metric.size() != units || !(metric.minCoeff() > 0.0)) return 0.0;
  const VectorXd c = (coupling(gated, units) * metric).cwiseQuotient(metric);
  const Affine gates(gated.gates);
  const VectorXd low = reading_min(model), high = reading_max(model);
  double share = 0.0;
  for (Index i = 0; i < units; ++i) {
    if (!(c(i) < 1.0)) return 0.0;
    double least = gates.bias(i) - gates.weights.row(i).head(units).cwiseAbs().sum();
    for (Index j = 0; j < low.size(); ++j) {
      const double w = gates.weights(i, units + j);
      least += std::min(w * low(j), w * high(j));
    }
    share = std::max(share, 1.0 - (1.0 - c(i)) / (1.0 + std::exp(-2.0 * least)));
  }
  return share < 1.0 ? -std::log(share) / model.sample_period_s : 0.0;
}

Contraction find_contraction(const Model& model, const Gated& gated) {
  const Index units = model.nz();
  constexpr int kIterations = 200;
  constexpr double kSmallest = 1e-3;  // relative to the largest; for rows without coupling
  const MatrixXd m = coupling(gated, units) + MatrixXd::Identity(units, units);  // the shift prevents oscillation
  VectorXd dominant = VectorXd::Ones(units);
  for (int i = 0; i < kIterations; ++i) {
    dominant = m * dominant;
    dominant /= dominant.maxCoeff();
  }
  Contraction best;
  for (const VectorXd& metric : {VectorXd(VectorXd::Ones(units)), VectorXd(dominant.cwiseMax(kSmallest))})
    if (const double rate = proven_rate(model, gated, metric); rate > best.rate) best = {metric, rate};
  return best;
}

}  // namespace nlo::codegen
