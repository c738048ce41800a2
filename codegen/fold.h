// SPDX-License-Identifier: MIT
// A model as it flies: features, normalisation and state scale folded into the layers, the latent system discretised.
// All in double; an export rounds each number once. Plain loops without contraction: the same model gives the same
// bits on every machine.
#pragma once

#include <vector>

#include "codegen/latent_step.h"
#include "codegen/model.h"

namespace nlo::codegen {

/// x_hat = mlp(in) + linear_path in, with in = [z; y], or z when no feature reads y.
struct FoldedModel {
  LatentStep step;              ///< over one sample period
  Eigen::MatrixXd steady_gain;  ///< S, n_z x n_y
  bool reads_output = false;    ///< in is [z; y]
  std::vector<DenseLayer> layers;
  Eigen::MatrixXd linear_path;  ///< n_x x n_in; 0 x 0: none (one layer takes it up)
  int stale_after = 0;          ///< measurements held in a row until the status says stale: one time constant of the
                                ///< fastest mode that reads an output, 5 at least
};

FoldedModel fold(const Model& model);

}  // namespace nlo::codegen
