// SPDX-License-Identifier: MIT
// Hermite polynomials over a cell: from values and derivatives at both ends of each state to tensors of coefficients.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "codegen/base/linear_algebra.h"

namespace nlo::trainer {

/// Returns the matrix from [value, derivatives] at -1, then at 1 (`m` numbers each), to the coefficients of the
/// polynomial of degree 2 m - 1.
inline Eigen::MatrixXd hermite(int m) {
  Eigen::MatrixXd conditions(2 * m, 2 * m);
  for (int end = 0; end < 2; ++end)
    for (int i = 0; i < m; ++i)
      for (int k = 0; k < 2 * m; ++k) {
        double factor = k >= i ? 1.0 : 0.0;
        for (int j = 0; j < i; ++j) factor *= k - j;
        conditions(end * m + i, k) = factor * (end == 0 && (k - i) % 2 != 0 ? -1.0 : 1.0);
      }
  return codegen::inverse(conditions);
}

/// Returns the powers of every product of states with at most `degree` in each state.
template <class Powers>
std::vector<Powers> all_powers(std::size_t nx, int degree) {
  std::vector<Powers> powers;
  Powers at{};
  for (;;) {
    powers.push_back(at);
    std::size_t p = 0;
    while (p < nx && at[p] == degree) at[p++] = 0;
    if (p == nx) return powers;
    ++at[p];
  }
}

/// Applies `map` along each state of a tensor, the first state fastest: `of_state(p)` (n x n) along state p. Each pass
/// makes its state the slowest, so that the original order is restored after the last pass.
template <class Scalar, class OfState>
void along_states(Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>& columns, Eigen::Index nx, Eigen::Index n,
                  const OfState& of_state) {
  using Block = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Index rest = columns.rows() / n;
  for (Eigen::Index p = 0; p < nx; ++p) {
    const Eigen::MatrixXd map = of_state(p);
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      const Block done = map * Eigen::Map<Block>(columns.col(c).data(), n, rest);
      Eigen::Map<Block>(columns.col(c).data(), rest, n) = done.transpose();
    }
  }
}

}  // namespace nlo::trainer
