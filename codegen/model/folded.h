// SPDX-License-Identifier: MIT
// A model in the form of its exports: features, normalisation and state scale are folded into the layers, and the
// latent system is discretised. All numbers are double; an export rounds each one once. Folding uses plain loops
// without contraction, so that a model gives the same bits on every machine. codegen/fold/fold.h makes it.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/model/error_head_parameters.h"
#include "codegen/model/flown_ranges.h"
#include "codegen/model/latent_step.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

/// The product in(factor) in(clock), which a folded network reads behind its inputs.
struct ClockProduct {
  Eigen::Index factor, clock;
  auto operator<=>(const ClockProduct&) const = default;
};

/// Returns [in; products] for one column of inputs.
template <class Vector>
Vector with_products(const std::vector<ClockProduct>& products, const Vector& in) {
  Vector all(in.size() + static_cast<Eigen::Index>(products.size()));
  all.head(in.size()) = in;
  for (std::size_t p = 0; p < products.size(); ++p)
    all(in.size() + static_cast<Eigen::Index>(p)) = in(products[p].factor) * in(products[p].clock);
  return all;
}

/// out = mlp(in) + linear_path in, then its fallback. The layers include normalisation and features. If there are
/// products, the first layer, the linear path and the fallback read [in; products].
struct FoldedNetwork {
  std::string field;                          ///< its name in the model file
  Activation activation = Activation::kTanh;  ///< may be a coarser tanh, which an export has chosen
  std::vector<DenseLayer> layers;
  Eigen::MatrixXd linear_path;  ///< n_out x columns(); 0 x 0: none (a network of one layer includes it)
  std::vector<ClockProduct> products = {};
  Fallback fallback = {};  ///< its rows have columns() columns

  Eigen::Index columns() const { return layers.front().weights.cols(); }  ///< inputs and products
  Eigen::Index inputs() const { return columns() - static_cast<Eigen::Index>(products.size()); }
};

struct FoldedModel {
  int stale_after = 0;
  FlownRanges ranges;                   ///< ranges in flight (flown_ranges.h)
  std::vector<FoldedNetwork> networks;  ///< in the order of networks(model)
  StepMatrices step;                    ///< over one sample period; empty if the latent system is not linear
  Eigen::MatrixXd steady_gain;          ///< S, n_z x n_r; zeros in that case
  std::optional<FoldedErrorHead> error = {};

  const FoldedNetwork& network(std::string_view field) const;  ///< the network must exist
  const FoldedNetwork* inverse_map() const;                    ///< null if z is the estimate
};

/// Folds a network. The result reads the first `inputs` inputs of the network; it must not depend on the others.
FoldedNetwork fold(const Network& network, Eigen::Index inputs);

/// Returns the folded network as a Network of `inputs` inputs, with an identity normalisation.
Network unfolded(const FoldedNetwork& folded, Eigen::Index inputs);

/// Returns a b with a fixed order of summation, independent of the vector width of the machine.
Eigen::MatrixXd ordered_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace nlo::codegen
