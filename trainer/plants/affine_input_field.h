// SPDX-License-Identifier: MIT
// The input field of a plant as numbers: what the driven observer (25) carries instead of the plant. It holds for an
// affine g, g(x) u = reshape(W x + b) u: a constant B, and bilinear plants.
#pragma once

#include <Eigen/Core>

#include "codegen/model/model.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

/// g(x) = reshape(W x + b, n_x, n_u), column after column, as codegen::Drive has it.
///   low, high  n_x  corners of the box that it is fitted on
/// W and b come from differences across the box and are checked at 256 drawn points of it. A constant g gives W = 0 and
/// b = g without rounding. Throws codegen::Error naming the input, the largest deviation and where it is when g is not
/// affine (beyond 1e-9 of its size), when f(x, u) is not affine in u, or when the plant has no input.
codegen::DenseLayer affine_input_field(const Plant& plant, const Eigen::VectorXd& low, const Eigen::VectorXd& high);

}  // namespace nlo::trainer
