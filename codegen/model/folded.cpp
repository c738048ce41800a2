// SPDX-License-Identifier: MIT
#include "codegen/model/folded.h"

#include <algorithm>
#include <utility>

namespace nlo::codegen {

Eigen::MatrixXd ordered_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  Eigen::MatrixXd c = Eigen::MatrixXd::Zero(a.rows(), b.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.cols(); ++j)
      for (Eigen::Index k = 0; k < a.cols(); ++k) c(i, j) += a(i, k) * b(k, j);
  return c;
}

const FoldedNetwork& FoldedModel::network(std::string_view field) const {
  return *std::find_if(networks.begin(), networks.end(), [&](const FoldedNetwork& n) { return n.field == field; });
}

const FoldedNetwork* FoldedModel::inverse_map() const {
  const auto found =
      std::find_if(networks.begin(), networks.end(), [](const FoldedNetwork& n) { return n.field == "inverse_map"; });
  return found == networks.end() ? nullptr : &*found;
}

FoldedNetwork fold(const Network& n, Eigen::Index inputs) {
  // u = G in + g
  Eigen::MatrixXd gain = n.features.leftCols(inputs);
  Eigen::MatrixXd offset(gain.rows(), 1);
  for (Eigen::Index i = 0; i < gain.rows(); ++i) {
    gain.row(i) /= n.feature_scale(i);
    offset(i, 0) = -n.feature_mean(i) / n.feature_scale(i);
  }

  FoldedNetwork folded{"", n.activation, n.layers, {}};
  DenseLayer& first = folded.layers.front();
  first.bias += ordered_product(first.weights, offset);
  first.weights = ordered_product(first.weights, gain);

  DenseLayer& last = folded.layers.back();
  if (n.skip.size() != 0) {
    last.bias += ordered_product(n.skip, offset);
    Eigen::MatrixXd linear_path = ordered_product(n.skip, gain);
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

Network unfolded(const FoldedNetwork& folded, Eigen::Index inputs) {
  const Eigen::Index reads = folded.inputs(), out = folded.layers.back().bias.size();
  return {.features = Eigen::MatrixXd::Identity(reads, inputs),
          .feature_mean = Eigen::VectorXd::Zero(reads),
          .feature_scale = Eigen::VectorXd::Ones(reads),
          .activation = folded.activation,
          .layers = folded.layers,
          .skip = folded.linear_path,
          .output_mean = Eigen::VectorXd::Zero(out),
          .output_scale = Eigen::VectorXd::Ones(out)};
}

}  // namespace nlo::codegen
