// SPDX-License-Identifier: MIT
// Is a plant that was written as expressions linear? Its values tell: f and h at unit vectors are the columns of A and
// C, and at random points f(x) - A x and h(x) - C x are no more than rounding.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "trainer/plants/linear.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct Linearity {
  std::unique_ptr<LinearPlant> plant;  ///< dx/dt = A x, y = C x; null when f or h is not linear
  bool affine = false;                 ///< linear but for f(0) or h(0), which are not zero: `plant` is null
};

/// Inputs are left out: f is what acts without them.
///   scale  n_x, > 0: sizes of the states of interest. Points go from a thousandth of them to a thousand times as far:
///          a dead zone, a saturation or a small cubic term in that range is seen
Linearity recognise_linear(const Plant& plant, const Eigen::VectorXd& scale);

}  // namespace nlo::trainer
