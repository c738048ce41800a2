// SPDX-License-Identifier: MIT
// How far a flown estimate can be from the real one. With a_l the flown activations of layer l, the real net behind
// layer l is the same for a_l and for the real layer's output from a_(l-1), so the error is a sum over the layers:
//   |flown - real|_i  <=  sum over l of  |d x_hat_i / d a_l| (activation's error + slope (sum's error))
// with the Jacobian of the real net behind l bounded over a box that holds both, and likewise for the error of the
// inputs. By branch and bound over the domain.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "codegen/model/model.h"
#include "trainer/prove/flown_map.h"
#include "trainer/prove/map_region.h"

namespace nlo::trainer {

struct ArithmeticError {
  Eigen::VectorXd bound;   ///< one for each output, n_x
  std::int64_t boxes = 0;  ///< looked at
};

/// Over all inputs of the region, [z; y], where the flown z is besides off by `latent_off` (n_z). A box is cut where
/// its bound is largest over `found` (n_x), until all are within `gap` of it.
ArithmeticError arithmetic_error(const codegen::Model& model, const MapRegion& region, const FlownMap& flown,
                                 const Eigen::VectorXd& latent_off, const Eigen::VectorXd& found, std::int64_t boxes,
                                 double gap);

}  // namespace nlo::trainer
