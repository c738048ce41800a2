// SPDX-License-Identifier: MIT
// The range of a hidden layer over a box, for a JacobianEnclosure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "trainer/prove/activation_slope.h"

namespace nlo::trainer {

/// The symbols are those of jacobian_enclosure.h.
struct LayerRange {
  SlopeLine slope;                    ///< per neuron: centre, gradient, remainders
  Eigen::MatrixXd mid;                ///< V at the slopes C of the layers before, n x n_p
  Eigen::MatrixXd rad;                ///< |V(p) - mid| is at most this, rounding included
  Eigen::MatrixXd most;               ///< bound of |V(p)|
  Eigen::VectorXd low, high;          ///< bounds of the pre-activations, rounding included
  Eigen::MatrixXd back;               ///< A of this layer
  Eigen::MatrixXd back_size;          ///< |A|, rounding included
  std::vector<Eigen::MatrixXd> from;  ///< maps from each layer before this one to this layer
};

/// Three enclosures of the outputs over the box: at its centre, as affine functions of p, and from the ranges of the
/// last layer's inputs.
struct AffineValues {
  Eigen::VectorXd at_centre, off;    ///< +- off
  Eigen::VectorXd middle, error;     ///< middle + gradient (p - centre) +- error
  Eigen::MatrixXd gradient;          ///< n_out x n_p
  Eigen::VectorXd interval, spread;  ///< +- spread
};

}  // namespace nlo::trainer
