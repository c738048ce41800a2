// SPDX-License-Identifier: MIT
// Describes T* over a box by its tangent at the centre and a bound of the distance between T* and the tangent. Unlike a
// Lipschitz constant, the tangent keeps the direction of an error.
#pragma once

#include <Eigen/Core>

#include "codegen/model/network.h"
#include "trainer/prove/jacobian_enclosure.h"

namespace nlo::trainer {

/// For p in the box, where the network's input is `inputs` p:
///   |map(inputs p) - value - slopes (p - centre)| <= beside + rounding
struct MapTangent {
  Eigen::VectorXd value, rounding, beside;  ///< n_out
  Eigen::MatrixXd slopes;                   ///< n_out x n_p

  /// Divides the box into `pieces` where `beside` is largest; `importance` (n_out) weights the outputs.
  MapTangent(const codegen::Network& map, const Eigen::MatrixXd& inputs, const InputBox& box,
             const Eigen::VectorXd& importance, int pieces);
};

}  // namespace nlo::trainer
