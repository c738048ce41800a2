// SPDX-License-Identifier: MIT
// Closed forms of linear systems with Eigen, whose templates compile slowly: instantiated once here, and only those
// that the exponential needs.
#pragma once

#include <Eigen/Core>

namespace nlo::testing {

/// e^A
Eigen::MatrixXd exponential(const Eigen::MatrixXd& a);

/// x with a x = b, and a^-1, for an invertible a.
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);

/// (a^T a)^-1 a^T, for an a with independent columns.
Eigen::MatrixXd pseudo_inverse(const Eigen::MatrixXd& a);

}  // namespace nlo::testing
