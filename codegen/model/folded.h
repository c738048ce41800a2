// SPDX-License-Identifier: MIT
// A model as it flies: features, normalisation and state scale folded into the layers, the latent system discretised.
// All in double; an export rounds each number once. Plain loops without contraction: the same model gives the same
// bits on every machine. codegen/fold/fold.h makes it.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "codegen/model/error_head.h"
#include "codegen/model/flown_ranges.h"
#include "codegen/model/latent_step.h"
#include "codegen/model/network.h"

namespace nlo::codegen {

/// out = mlp(in) + linear_path in: normalisation and features are in the layers.
struct FoldedNetwork {
  std::string field;                          ///< its name in the model file
  Activation activation = Activation::kTanh;  ///< once it is chosen, a coarser tanh
  std::vector<DenseLayer> layers;
  Eigen::MatrixXd linear_path;  ///< n_out x n_in; 0 x 0: none (one layer takes it up)

  Eigen::Index inputs() const { return layers.front().weights.cols(); }
};

struct FoldedModel {
  int stale_after = 0;
  FlownRanges ranges;                   ///< as the readings fly (flown_ranges.h)
  std::vector<FoldedNetwork> networks;  ///< networks(model), in their order
  StepMatrices step;                    ///< over one sample period; empty where the latent system is not linear
  Eigen::MatrixXd steady_gain;          ///< S, n_z x n_r; zeros there
  std::optional<FoldedErrorHead> error = {};

  const FoldedNetwork& network(std::string_view field) const;  ///< which must be there
  const FoldedNetwork* inverse_map() const;                    ///< null where z is the estimate
};

/// `network` folded. Reads the first `inputs` entries of what the network reads: the others must not matter to it.
FoldedNetwork fold(const Network& network, Eigen::Index inputs);

/// The folded network as one of `inputs` inputs, whose first it reads: nothing is left to normalise.
Network unfolded(const FoldedNetwork& folded, Eigen::Index inputs);

/// a b with one order of summation, whatever the machine's vector width is.
Eigen::MatrixXd ordered_product(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace nlo::codegen
