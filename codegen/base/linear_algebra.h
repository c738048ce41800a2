// SPDX-License-Identifier: MIT
// Eigen's factorisations of matrices with dynamic sizes, compiled once, because they take most of the compile time of a
// source that includes them.
#pragma once

#include <Eigen/Core>

namespace nlo::codegen {

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& a);

struct Eigensystem {
  Eigen::VectorXcd values;
  Eigen::MatrixXcd vectors;  ///< in columns
};
Eigensystem eigensystem(const Eigen::MatrixXd& a);

/// Returns S with S S' = a for a symmetric semidefinite a. Not finite if a is not.
Eigen::MatrixXd square_root(const Eigen::MatrixXd& a);

/// Returns the singular values, largest first.
Eigen::VectorXd singular_values(const Eigen::MatrixXd& a);
Eigen::VectorXd singular_values(const Eigen::MatrixXcd& a);

/// Returns a^-1, or x with a x = b, for an invertible a.
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);
Eigen::MatrixXcd inverse(const Eigen::MatrixXcd& a);
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXcd solve(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b);

/// Solves like solve() for a symmetric semidefinite a. Only its lower half is read.
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// Returns the shortest x that minimises |a x - b|, column by column. For b = I this is the pseudo-inverse of a.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

}  // namespace nlo::codegen
