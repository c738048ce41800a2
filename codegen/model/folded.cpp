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

namespace {

/// Returns the products of all features with clocks, each once, in rising order.
std::vector<ClockProduct> products_of(const Network& n, Eigen::Index inputs) {
  std::vector<ClockProduct> products;
  for (std::size_t f = 0; f < n.feature_clocks.size(); ++f)
    for (Eigen::Index i = 0; n.feature_clocks[f] >= 0 && i < inputs; ++i)
      if (n.features(static_cast<Eigen::Index>(f), i) != 0.0) products.push_back({i, n.feature_clocks[f]});
  std::ranges::sort(products);
  products.erase(std::unique(products.begin(), products.end()), products.end());
  return products;
}

/// Moves row i of the gain, which belongs to a feature, to the products with its clock. The offset of the row becomes a
/// multiple of the clock.
void multiply_by_clock(Eigen::Index i, Eigen::Index clock, const std::vector<ClockProduct>& products,
                       Eigen::MatrixXd& gain, Eigen::MatrixXd& offset) {
  const Eigen::Index inputs = gain.cols() - static_cast<Eigen::Index>(products.size());
  for (std::size_t p = 0; p < products.size(); ++p)
    if (products[p].clock == clock) gain(i, inputs + static_cast<Eigen::Index>(p)) = gain(i, products[p].factor);
  gain.row(i).head(inputs).setZero();
  gain(i, clock) = offset(i, 0);
  offset(i, 0) = 0.0;
}

}  // namespace

FoldedNetwork fold(const Network& n, Eigen::Index inputs) {
  const std::vector<ClockProduct> products = products_of(n, inputs);
  // u = G [in; products] + g
  Eigen::MatrixXd gain = Eigen::MatrixXd::Zero(n.features.rows(), inputs + static_cast<Eigen::Index>(products.size()));
  gain.leftCols(inputs) = n.features.leftCols(inputs);
  Eigen::MatrixXd offset(gain.rows(), 1);
  for (Eigen::Index i = 0; i < gain.rows(); ++i) {
    gain.row(i) /= n.feature_scale(i);
    offset(i, 0) = -n.feature_mean(i) / n.feature_scale(i);
    if (const int clock = clock_of(n, i); clock >= 0) multiply_by_clock(i, clock, products, gain, offset);
  }

  FoldedNetwork folded{"", n.activation, n.layers, {}, products};
  DenseLayer& first = folded.layers.front();
  first.bias += ordered_product(first.weights, offset);
  first.weights = ordered_product(first.weights, gain);

  if (!n.fallback.outputs.empty()) {
    folded.fallback = n.fallback;
    folded.fallback.rows = ordered_product(n.fallback.rows, gain);
    folded.fallback.offset += ordered_product(n.fallback.rows, offset);
  }

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
  const Eigen::Index reads = folded.columns(), own = folded.inputs(), out = folded.layers.back().bias.size();
  Eigen::MatrixXd features = Eigen::MatrixXd::Zero(reads, inputs);
  features.topRows(own).setIdentity();
  std::vector<int> clocks(folded.products.empty() ? 0 : static_cast<std::size_t>(reads), -1);
  for (std::size_t p = 0; p < folded.products.size(); ++p) {
    const Eigen::Index row = own + static_cast<Eigen::Index>(p);
    features(row, folded.products[p].factor) = 1.0;
    clocks[static_cast<std::size_t>(row)] = static_cast<int>(folded.products[p].clock);
  }
  return {.features = features,
          .feature_mean = Eigen::VectorXd::Zero(reads),
          .feature_scale = Eigen::VectorXd::Ones(reads),
          .feature_clocks = clocks,
          .activation = folded.activation,
          .layers = folded.layers,
          .skip = folded.linear_path,
          .output_mean = Eigen::VectorXd::Zero(out),
          .output_scale = Eigen::VectorXd::Ones(out),
          .fallback = folded.fallback};
}

}  // namespace nlo::codegen
