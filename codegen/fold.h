// SPDX-License-Identifier: MIT
// A model as it flies: features, normalisation and state scale folded into the layers, the latent system discretised.
// All in double; an export rounds each number once. Plain loops without contraction: the same model gives the same
// bits on every machine.
#pragma once

#include <string>
#include <vector>

#include "codegen/latent_step.h"
#include "codegen/model.h"

namespace nlo::codegen {

/// out = mlp(in) + linear_path in: normalisation and features are in the layers.
struct FoldedNetwork {
  std::string activation;  ///< tanh, relu or silu; once it is chosen, tanh5e6 or tanh5e5
  std::vector<DenseLayer> layers;
  Eigen::MatrixXd linear_path;  ///< n_out x n_in; 0 x 0: none (one layer takes it up)

  Eigen::Index inputs() const { return layers.front().weights.cols(); }
  bool empty() const { return layers.empty(); }
};

/// Every structure folds to what it has; the rest is empty.
struct FoldedModel {
  int stale_after = 0;  ///< measurements held in a row until the status says stale: one time constant of the fastest
                        ///< mode that reads an output, 5 at least; 10 where no mode is known (general)
  bool reads_output = false;  ///< the inverse map reads [z; y] rather than z
  FoldedNetwork inverse_map;  ///< kkl, driven_kkl, general

  // kkl, driven_kkl
  LatentStep step;              ///< over one sample period
  Eigen::MatrixXd steady_gain;  ///< S, n_z x n_y

  // driven_kkl
  ForcedLatentStep forced;  ///< over one sample period
  FoldedNetwork forward_map;

  // luenberger
  Eigen::MatrixXd error_matrix;  ///< A - G C
  FoldedNetwork nonlinearity;

  // general
  FoldedNetwork dynamics;
};

/// `network` folded. Reads the first `inputs` entries of what the network reads: the others must not matter to it.
FoldedNetwork fold(const Network& network, Eigen::Index inputs);

FoldedModel fold(const Model& model);

}  // namespace nlo::codegen
