// SPDX-License-Identifier: MIT
#include "codegen/base/linear_algebra.h"

#include <Eigen/Dense>
#include <limits>

namespace nlo::codegen {
namespace {

// Returns [Re, -Im; Im, Re] of a complex matrix, for the real factorisations. Complex factorisations would take as long
// to compile as the rest of this file.
Eigen::MatrixXd real_form(const Eigen::MatrixXcd& a) {
  Eigen::MatrixXd real(2 * a.rows(), 2 * a.cols());
  real << a.real(), -a.imag(), a.imag(), a.real();
  return real;
}

Eigen::MatrixXcd of_left_half(const Eigen::MatrixXd& real, Eigen::Index cols) {
  const Eigen::Index rows = real.rows() / 2;
  Eigen::MatrixXcd a(rows, cols);
  a.real() = real.topLeftCorner(rows, cols);
  a.imag() = real.bottomLeftCorner(rows, cols);
  return a;
}

}  // namespace

Eigen::VectorXcd eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::EigenSolver<Eigen::MatrixXd>(a, false).eigenvalues();
}

Eigensystem eigensystem(const Eigen::MatrixXd& a) {
  const Eigen::EigenSolver<Eigen::MatrixXd> solver(a);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::MatrixXd square_root(const Eigen::MatrixXd& a) {
  const Eigen::LLT<Eigen::MatrixXd> cholesky(a);
  if (cholesky.info() == Eigen::Success) return cholesky.matrixL();
  if (!a.allFinite()) return Eigen::MatrixXd::Constant(a.rows(), a.cols(), std::numeric_limits<double>::quiet_NaN());
  const Eigen::LDLT<Eigen::MatrixXd> factors(a);  // a = P' L D L' P
  const Eigen::MatrixXd lower = factors.matrixL();
  const Eigen::VectorXd roots = factors.vectorD().cwiseMax(0.0).cwiseSqrt();
  return factors.transpositionsP().transpose() * (lower * roots.asDiagonal()).eval();
}

Eigen::VectorXd singular_values(const Eigen::MatrixXd& a) {
  return Eigen::JacobiSVD<Eigen::MatrixXd>(a).singularValues();
}

Eigen::VectorXd singular_values(const Eigen::MatrixXcd& a) {
  const Eigen::VectorXd each_twice = singular_values(real_form(a));
  return each_twice(Eigen::seq(0, Eigen::last, 2));
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd& a) {
  return a.partialPivLu().inverse();
}

Eigen::MatrixXcd inverse(const Eigen::MatrixXcd& a) {
  return of_left_half(inverse(real_form(a)), a.cols());
}

Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.partialPivLu().solve(b);
}

Eigen::MatrixXcd solve(const Eigen::MatrixXcd& a, const Eigen::MatrixXcd& b) {
  Eigen::MatrixXd stacked(2 * b.rows(), b.cols());
  stacked << b.real(), b.imag();
  return of_left_half(solve(real_form(a), stacked), b.cols());
}

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.ldlt().solve(b);
}

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.completeOrthogonalDecomposition().solve(b);
}

}  // namespace nlo::codegen
