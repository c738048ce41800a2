// SPDX-License-Identifier: MIT
// T* over a box as its tangent at the centre and how far T* is from it: It keeps the directions of an error; a
// Lipschitz constant keeps only its size.
#pragma once

#include <Eigen/Core>

#include "codegen/model/network.h"
#include "trainer/prove/jacobian_enclosure.h"

namespace nlo::trainer {

/// For p in the box, with `inputs` p as the network's input:
///   |map(inputs p) - value - slopes (p - centre)| <= beside + rounding
struct MapTangent {
  Eigen::VectorXd value, rounding, beside;  ///< n_out
  Eigen::MatrixXd slopes;                   ///< n_out x n_p

  /// Cuts the box into `pieces` where `beside` is most; `importance` (n_out) weighs the outputs beside one another.
  MapTangent(const codegen::Network& map, const Eigen::MatrixXd& inputs, const InputBox& box,
             const Eigen::VectorXd& importance, int pieces);
};

}  // namespace nlo::trainer
