// SPDX-License-Identifier: MIT
// What a JacobianEnclosure knows of a hidden layer over a box.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/bounds/activation_slope.h"

namespace nlo::trainer {

/// The symbols are those of jacobian_enclosure.h.
struct LayerRange {
  SlopeLine slope;                    ///< per neuron: centre, gradient, remainders
  Eigen::MatrixXd mid;                ///< V at the slopes C of the layers before, n x n_p
  Eigen::MatrixXd rad;                ///< |V(p) - mid| is at most this, rounding included
  Eigen::MatrixXd most;               ///< |V(p)|
  Eigen::VectorXd half_width;         ///< of the pre-activations' range
  Eigen::MatrixXd back;               ///< A of the layer that is looked at
  Eigen::MatrixXd back_size;          ///< |A|, rounding included
  std::vector<Eigen::MatrixXd> from;  ///< A of this layer, of each layer before it
};

}  // namespace nlo::trainer
