// SPDX-License-Identifier: MIT
// Closed forms of linear systems, by Eigen, whose templates take long to compile: here once, and no more of them than
// the exponential needs anyway.
#pragma once

#include <Eigen/Core>

namespace nlo::testing {

/// e^A
Eigen::MatrixXd exponential(const Eigen::MatrixXd& a);

/// x with a x = b, and a^-1, for a that has an inverse.
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);

/// (a^T a)^-1 a^T, for a whose columns are independent.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a);

}  // namespace nlo::testing
