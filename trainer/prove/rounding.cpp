// SPDX-License-Identifier: MIT
#include "trainer/prove/rounding.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace nlo::trainer {
namespace {

/// Returns true if a Cholesky factorisation of t I - g succeeds. Small matrices use no heap.
template <class Storage>
bool is_above(double t, const Eigen::MatrixXd& g) {
  const Eigen::Index n = g.rows();
  Storage l = -g;
  l.diagonal().array() += t;
  for (Eigen::Index j = 0; j < n; ++j) {
    double& pivot = l(j, j);
    if (!(pivot > 0.0)) return false;
    pivot = std::sqrt(pivot);
    for (Eigen::Index i = j + 1; i < n; ++i) l(i, j) /= pivot;
    for (Eigen::Index k = j + 1; k < n; ++k)
      for (Eigen::Index i = k; i < n; ++i) l(i, k) -= l(k, j) * l(i, j);
  }
  return true;
}
bool is_above(double t, const Eigen::MatrixXd& g) {
  constexpr int kSmall = 8;
  using Small = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kSmall, kSmall>;
  return g.rows() <= kSmall ? is_above<Small>(t, g) : is_above<Eigen::MatrixXd>(t, g);
}

/// Returns the bound of the eigenvalues of g (n x n) that holds if is_above(t) succeeds.
double proven(double t, Eigen::Index n) {
  const auto size = static_cast<double>(n);
  return upward(t * (1.0 + 2.0 * size * (size + 2.0) * kUnit), 3);
}

/// Bounds the error of the computed G, |G - m'm| <= gamma |m|'|m|. The norm is at most the trace.
double error_of_gram(const Eigen::MatrixXd& m, double trace) {
  return upward(gamma(std::max(m.rows(), m.cols())) * trace, 1);
}

double raised_trace(const Eigen::MatrixXd& m) {
  return upward(m.squaredNorm(), m.size());
}

/// Returns the norm of a matrix with two rows or two columns.
template <class First, class Second>
double norm_of_two(const First& a, const Second& b, double of_gram) {
  const double aa = a.squaredNorm(), bb = b.squaredNorm(), ab = a.dot(b), half = 0.5 * (aa - bb);
  const double largest = 0.5 * (aa + bb) + std::sqrt(half * half + ab * ab);
  return upward(std::sqrt(upward(largest, 6) + of_gram), 2);
}

/// Returns a lower bound of the largest eigenvalue of g, which is usually close to it.
double by_powers(const Eigen::MatrixXd& g) {
  constexpr int kRounds = 10;
  Eigen::VectorXd v = g.rowwise().norm(), next = v;
  for (int i = 0; i < kRounds; ++i) {
    next.noalias() = g * v;
    v = next / next.norm();
  }
  next.noalias() = g * v;
  return next.norm();
}

Eigen::MatrixXd small_gram(const Eigen::MatrixXd& m) {
  return m.rows() < m.cols() ? Eigen::MatrixXd(m * m.transpose()) : Eigen::MatrixXd(m.transpose() * m);
}

}  // namespace

double frobenius_above(const Eigen::MatrixXd& m) {
  return upward(std::sqrt(m.squaredNorm()), m.size() + 1);
}

double norm_above(const Eigen::MatrixXd& m, double at_least) {
  constexpr int kTries = 12;
  if (m.isZero(0.0)) return at_least;
  if (!m.allFinite()) return std::numeric_limits<double>::infinity();
  const Eigen::Index n = std::min(m.rows(), m.cols());
  const double trace = raised_trace(m), frobenius = upward(std::sqrt(trace), 1);
  if (n == 1 || frobenius <= at_least) return std::max(frobenius, at_least);
  const double of_gram = error_of_gram(m, trace);
  if (n == 2)
    return std::max(
        at_least, m.rows() == 2 ? norm_of_two(m.row(0), m.row(1), of_gram) : norm_of_two(m.col(0), m.col(1), of_gram));
  const Eigen::MatrixXd gram = small_gram(m);
  const auto norm = [&](double t) { return upward(std::sqrt(proven(t, n) + of_gram), 2); };
  if (at_least > 0.0) {
    const double t = at_least * at_least * (1.0 - 8.0 * static_cast<double>(n * n + m.size()) * kUnit);
    if (norm(t) <= at_least && is_above(t, gram)) return at_least;
  }
  const double computed =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(gram, Eigen::EigenvaluesOnly).eigenvalues().maxCoeff();
  double margin = 4.0 * static_cast<double>(n * (n + 2)) * kUnit;
  for (int i = 0; i < kTries; ++i, margin *= 8.0) {
    const double t = computed * (1.0 + margin) + std::numeric_limits<double>::min();
    if (t > trace) break;
    if (is_above(t, gram)) return std::max(norm(t), at_least);
  }
  return std::max(frobenius, at_least);  // the spectral norm is never above the Frobenius norm
}

double rough_norm_above(const Eigen::MatrixXd& m) {
  constexpr double kStep = 1.003;  // factor of the norm's square
  constexpr int kTries = 4;
  constexpr Eigen::Index kFew = 4;
  const Eigen::Index n = std::min(m.rows(), m.cols());
  if (n <= kFew || !m.allFinite()) return norm_above(m);
  const Eigen::MatrixXd gram = small_gram(m);
  double t = by_powers(gram);
  for (int i = 0; i < kTries; ++i)
    if (t *= kStep; is_above(t, gram)) return upward(std::sqrt(proven(t, n) + error_of_gram(m, raised_trace(m))), 2);
  return norm_above(m);
}

}  // namespace nlo::trainer
