// SPDX-License-Identifier: MIT
// Bounds the difference between an exported estimate and the real one. Let a_l be the exported activations of layer l.
// The real network after layer l is the same for a_l and for the real output of layer l from a_(l-1), so the error is a
// sum over the layers:
//   |exported - real|_i  <=  sum over l of  |d x_hat_i / d a_l| (activation's error + slope (sum's error))
// The Jacobian of the real network after l is bounded over a box that contains both. The error of the inputs has such a
// term, too. Branch and bound over the domain makes the bound sharp.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"
#include "trainer/prove/flown_map.h"
#include "trainer/prove/map_region.h"

namespace nlo::trainer {

struct ArithmeticError {
  Eigen::VectorXd bound;   ///< one for each output, n_x
  std::int64_t boxes = 0;  ///< number of examined boxes
};

/// Bounds the rounding error of the exported T* over all inputs [z; y] of the region, if z has an error of at most
/// `latent_off` (n_z). Divides the box whose bound is largest relative to `found` (n_x, the largest errors seen), until
/// every bound is at most (1 + gap) found, or `boxes` boxes are examined.
ArithmeticError arithmetic_error(const codegen::Model& model, const MapRegion& region, const FlownMap& flown,
                                 const Eigen::VectorXd& latent_off, const Eigen::VectorXd& found, std::int64_t boxes,
                                 double gap);

}  // namespace nlo::trainer
