// SPDX-License-Identifier: MIT
// Tests whether a plant given by expressions is linear: f and h at unit vectors are the columns of A and C, and at
// random points f(x) - A x and h(x) - C x must be zero up to rounding. Also fits the input field of a plant as numbers
// for the driven observer (25). The field must be affine, g(x) u = reshape(W x + b) u, as with a constant B or in
// bilinear plants.
#pragma once

#include <Eigen/Core>
#include <memory>

#include "codegen/model/model.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct Linearity {
  std::unique_ptr<LinearPlant> plant;  ///< dx/dt = A x, y = C x; null if f or h is not linear
  bool affine = false;                 ///< true: linear except for nonzero constants f(0) or h(0); then `plant` is null
};

/// Ignores inputs: f is the derivative without them.
///   scale  n_x, > 0: sizes of the states of interest. Points reach from a thousandth to a thousand times them, so that
///   a dead zone, a saturation or a small cubic term in that range is detected
Linearity recognise_linear(const Plant& plant, const Eigen::VectorXd& scale);

/// Fits g(x) = reshape(W x + b, n_x, n_u), column after column, in the form of codegen::Drive.
///   low, high  n_x  corners of the box that it is fitted on
/// W and b come from differences across the box and are checked at 256 random points of it. A constant g gives W = 0
/// and b = g without rounding. Throws codegen::Error with the input, the largest deviation and its place if g is not
/// affine (beyond 1e-9 of its size), if f(x, u) is not affine in u, or if the plant has no input.
codegen::DenseLayer affine_input_field(const Plant& plant, const Eigen::VectorXd& low, const Eigen::VectorXd& high);

}  // namespace nlo::trainer
