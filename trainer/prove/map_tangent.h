// SPDX-License-Identifier: MIT
// T* over a box, as its tangent at the centre and the distance of T* from it. It keeps the direction of an error, where
// a Lipschitz constant only keeps its size.
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
