// SPDX-License-Identifier: MIT
#include "codegen/fold.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace nlo::codegen {
namespace {

/// a b with one order of summation, whatever the machine's vector width is.
Eigen::MatrixXd product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(a.rows(), b.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.cols(); ++j)
      for (Eigen::Index k = 0; k < a.cols(); ++k) c(i, j) += a(i, k) * b(k, j);
  return c;
}

int stale_after(const Model& m, const FoldedModel& folded) {
  double fastest = 0.0;  // 1/s
  if (m.dynamics) return 10;
  if (m.luenberger) fastest = -folded.error_matrix.eigenvalues().real().minCoeff();
  for (int r = 0; r < m.eigenvalues.size(); ++r) {
    const bool paired = r < 2 * m.pairs;
    if (m.output_injection.middleRows(r, paired ? 2 : 1).isZero(0.0)) continue;  // a clock
    fastest = std::max(fastest, -m.eigenvalues(r));
    if (paired) ++r;
  }
  constexpr double kFewest = 5.0, kMost = 65535.0;  // what the runtime can count
  return static_cast<int>(std::clamp(std::round(1.0 / (fastest * m.sample_period_s)), kFewest, kMost));
}

}  // namespace

FoldedNetwork fold(const Network& n, Eigen::Index inputs) {
  // u = G in + g
  Eigen::MatrixXd gain = n.features.leftCols(inputs);
  Eigen::MatrixXd offset(gain.rows(), 1);
  for (Eigen::Index i = 0; i < gain.rows(); ++i) {
    gain.row(i) /= n.feature_scale(i);
    offset(i, 0) = -n.feature_mean(i) / n.feature_scale(i);
  }

  FoldedNetwork folded{n.activation, n.layers, {}};
  DenseLayer& first = folded.layers.front();
  first.bias += product(first.weights, offset);
  first.weights = product(first.weights, gain);

  DenseLayer& last = folded.layers.back();
  if (n.skip.size() != 0) {
    last.bias += product(n.skip, offset);
    Eigen::MatrixXd linear_path = product(n.skip, gain);
    if (folded.layers.size() == 1) {
      last.weights += linear_path;
    } else {
      folded.linear_path = std::move(linear_path);
    }
  }
  for (Eigen::Index i = 0; i < last.bias.size(); ++i) {
    last.weights.row(i) *= n.output_scale(i);
    last.bias(i) = last.bias(i) * n.output_scale(i) + n.output_mean(i);
    if (folded.linear_path.size() != 0) folded.linear_path.row(i) *= n.output_scale(i);
  }
  return folded;
}

FoldedModel fold(const Model& m) {
  FoldedModel folded;
  if (has_linear_latent(m)) {
    const Network& map = m.inverse_map;
    folded.step = latent_step(m, m.sample_period_s);
    folded.steady_gain = steady_gain(m);
    folded.reads_output = !map.features.rightCols(m.ny()).isZero(0.0);
    folded.inverse_map = fold(map, folded.reads_output ? map.features.cols() : m.nz());
  }
  if (m.drive) {
    folded.forced = forced_latent_step(m, m.sample_period_s);
    folded.forward_map = fold(m.drive->forward_map, m.nx());
  }
  if (m.luenberger) {
    const LuenbergerDynamics& l = *m.luenberger;
    folded.error_matrix = l.state_matrix - product(l.gain, l.output_matrix);
    folded.nonlinearity = fold(l.nonlinearity, m.nx());
  }
  if (m.dynamics) {
    folded.dynamics = fold(*m.dynamics, m.nz() + m.ny());
    folded.inverse_map = fold(m.inverse_map, m.nz());
  }
  folded.stale_after = stale_after(m, folded);
  return folded;
}

}  // namespace nlo::codegen
