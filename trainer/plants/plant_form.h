// SPDX-License-Identifier: MIT
// Is a plant that was written as expressions linear? Its values tell: f and h at unit vectors are the columns of A and
// C, and at random points f(x) - A x and h(x) - C x are no more than rounding.
// The input field of a plant as numbers, which the driven observer (25) has in place of the plant. It holds for an
// affine g, g(x) u = reshape(W x + b) u: a constant B, and bilinear plants.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "codegen/model/model.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct Linearity {
  std::unique_ptr<LinearPlant> plant;  ///< dx/dt = A x, y = C x; null when f or h is not linear
  bool affine = false;                 ///< linear but for f(0) or h(0), which are not zero: `plant` is null
};

/// Inputs are left out: f is the derivative without them.
///   scale  n_x, > 0: sizes of the states of interest. Points go from a thousandth of them to a thousand times as far:
///          a dead zone, a saturation or a small cubic term in that range is seen
Linearity recognise_linear(const Plant& plant, const Eigen::VectorXd& scale);

/// g(x) = reshape(W x + b, n_x, n_u), column after column, as codegen::Drive has it.
///   low, high  n_x  corners of the box that it is fitted on
/// W and b come from differences across the box and are checked at 256 drawn points of it. A constant g gives W = 0 and
/// b = g without rounding. Throws codegen::Error naming the input, the largest deviation and where it is when g is not
/// affine (beyond 1e-9 of its size), when f(x, u) is not affine in u, or when the plant has no input.
codegen::DenseLayer affine_input_field(const Plant& plant, const Eigen::VectorXd& low, const Eigen::VectorXd& high);

}  // namespace nlo::trainer
