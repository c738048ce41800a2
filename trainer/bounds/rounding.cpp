// SPDX-License-Identifier: MIT
#include "trainer/bounds/rounding.h"

#include <algorithm>
#include <cmath>

#include "codegen/base/linear_algebra.h"

namespace nlo::trainer {
namespace {

/// Does a Cholesky factorisation of t I - g come to its end?
bool is_above(double t, const Eigen::MatrixXd& g) {
  const Eigen::Index n = g.rows();
  Eigen::MatrixXd l = -g;
  l.diagonal().array() += t;
  for (Eigen::Index j = 0; j < n; ++j) {
    double& pivot = l(j, j);
    if (!(pivot > 0.0)) return false;
    pivot = std::sqrt(pivot);
    const Eigen::Index below = n - j - 1;
    l.col(j).tail(below) /= pivot;
    for (Eigen::Index k = j + 1; k < n; ++k) l.col(k).tail(n - k) -= l(k, j) * l.col(j).tail(n - k);
  }
  return true;
}

}  // namespace

double frobenius_above(const Eigen::MatrixXd& m) {
  return upward(std::sqrt(m.squaredNorm()), static_cast<double>(m.size()) + 1.0);
}

double norm_above(const Eigen::MatrixXd& m) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  constexpr int kTries = 12;
  if (m.size() == 0) return 0.0;
  if (!m.allFinite()) return kInfinite;
  const Eigen::MatrixXd gram =
      m.rows() < m.cols() ? Eigen::MatrixXd(m * m.transpose()) : Eigen::MatrixXd(m.transpose() * m);
  const auto n = static_cast<double>(gram.rows()), terms = static_cast<double>(std::max(m.rows(), m.cols()));
  if (gram.rows() == 1) return frobenius_above(m);
  // |G - m'm| <= gamma |m|'|m|, whose norm is at most its trace.
  const double trace = upward(m.squaredNorm(), static_cast<double>(m.size()));
  const double of_gram = upward(gamma(terms) * trace, 1.0);
  if (gram.rows() == 2) {
    const double half = 0.5 * (gram(0, 0) - gram(1, 1));
    const double largest = 0.5 * (gram(0, 0) + gram(1, 1)) + std::sqrt(half * half + gram(0, 1) * gram(0, 1));
    return upward(std::sqrt(upward(largest, 6.0) + of_gram), 2.0);
  }
  const double computed = codegen::largest_eigenvalue(gram);
  double margin = 4.0 * n * (n + 2.0) * kUnit;
  for (int i = 0; i < kTries; ++i, margin *= 8.0) {
    const double t = computed * (1.0 + margin) + std::numeric_limits<double>::min();
    if (t > trace) break;
    if (is_above(t, gram))
      return upward(std::sqrt(upward(t * (1.0 + 2.0 * n * (n + 2.0) * kUnit), 3.0) + of_gram), 2.0);
  }
  return frobenius_above(m);  // no norm is above it
}

}  // namespace nlo::trainer
