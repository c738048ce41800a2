// SPDX-License-Identifier: MIT
// Constants and functions that account for rounding errors of computations in double, so that a computed bound holds
// for real numbers. The processor's rounding mode is not changed. Bounds are computed to nearest and then raised by
// more than all of their roundings together (Higham, Accuracy and Stability of Numerical Algorithms, 2002, chapter 3:
// in any order of the sums, with or without fused multiply-adds).
//
// Assumed: IEEE doubles, no -ffast-math, no overflow (a bound is then infinite, which holds), and functions of the
// standard library that are within kLibraryUlps of the real ones (glibc documents 2 for tanh and exp).
#pragma once

#include <Eigen/Core>
#include <limits>

namespace nlo::trainer {

/// u: the error of a rounded result is at most u times its size.
inline constexpr double kUnit = 0x1p-53;
inline constexpr double kLibraryUlps = 4.0;

/// gamma_n = n u / (1 - n u), rounded up: n successive roundings multiply a result by a factor within [1 - gamma_n, 1 +
/// gamma_n], and a scalar product of n terms has an error of at most gamma_n |a|'|b|. Valid for n below 2^50.
template <class Count>
constexpr double gamma(Count n) {
  const double exact = static_cast<double>(n) * kUnit;  // exact, because n u and 1 - n u are doubles
  return exact / (1.0 - exact) * (1.0 + 4.0 * kUnit);
}

/// Returns a bound of the exact value, if `value` >= 0 was computed from terms >= 0, and each term went through at most
/// `roundings` sums, products, quotients and roots. Also valid for results below 1e-308.
template <class Count>
constexpr double upward(double value, Count roundings) {
  return value * (1.0 + gamma(static_cast<double>(roundings) + 2.0)) + std::numeric_limits<double>::min();
}
template <class Count>
Eigen::MatrixXd upward(const Eigen::MatrixXd& value, Count roundings) {
  return value.unaryExpr([roundings](double entry) { return upward(entry, roundings); });
}

/// Returns a bound of |a b - its computed value|, entry by entry.
inline Eigen::MatrixXd product_error(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return upward(gamma(a.cols()) * (a.cwiseAbs() * b.cwiseAbs()), a.cols() + 1);
}

/// Returns a bound of the largest singular value of m that exceeds it by about n^2 roundings only. If a Cholesky
/// factorisation of t I - G succeeds, no eigenvalue of G exceeds t by more than its own rounding (Rump, Verification of
/// positive definiteness, 2006). Infinite if m is not finite. With `at_least`, returns the larger of the bound and
/// `at_least`; this is faster if `at_least` is larger.
double norm_above(const Eigen::MatrixXd& m, double at_least = 0.0);

/// Returns a bound of the norm within a per cent, in a fifth of the time for matrices of more than a few rows and
/// columns.
double rough_norm_above(const Eigen::MatrixXd& m);

/// Returns a bound of the square root of the sum of squares of all entries.
double frobenius_above(const Eigen::MatrixXd& m);

}  // namespace nlo::trainer
