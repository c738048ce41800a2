// SPDX-License-Identifier: MIT
#include "trainer/structures/observer_gain.h"

#include <fmt/format.h>

#include <cmath>
#include <complex>

#include "codegen/base/linear_algebra.h"
#include "trainer/base/number_text.h"
#include "trainer/config/key_error.h"

namespace nlo::trainer {

namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Returns [C; C A; ...; C A^(n-1)].
MatrixXd observability(const MatrixXd& a, const MatrixXd& c) {
  MatrixXd result(c.rows() * a.rows(), a.cols());
  MatrixXd block = c;
  for (Index i = 0; i < a.rows(); ++i) {
    result.middleRows(i * c.rows(), c.rows()) = block;
    block = (block * a).eval();
  }
  return result;
}

MatrixXd matrix_of(const char* key, const std::vector<std::vector<double>>& rows, int count, int columns) {
  const auto fail = [&](const std::string& what) {
    throw KeyError(fmt::format("observer.{}", key),
                   fmt::format("[observer] {} {}; it must be {} rows of {} numbers", key, what, count, columns));
  };
  if (rows.empty()) fail("is missing");
  if (rows.size() != static_cast<std::size_t>(count)) fail(fmt::format("has {} rows", rows.size()));
  MatrixXd result(count, columns);
  for (int i = 0; i < count; ++i) {
    const auto& row = rows[static_cast<std::size_t>(i)];
    if (row.size() != static_cast<std::size_t>(columns)) fail(fmt::format("has {} numbers in row {}", row.size(), i));
    result.row(i) = Eigen::Map<const Eigen::RowVectorXd>(row.data(), columns);
  }
  return result;
}

}  // namespace

MatrixXd place_poles(const MatrixXd& a, const MatrixXd& c, const VectorXd& poles) {
  const Index n = a.rows();
  // Almost every combination of the outputs contains every mode. Tries a few and uses the best-conditioned one.
  VectorXd weights;
  double clearest = 0.0;
  for (int trial = 0; trial < 8; ++trial) {
    VectorXd candidate(c.rows());
    for (Index j = 0; j < c.rows(); ++j)
      candidate(j) = std::cos(static_cast<double>(trial) * (1.0 + 2.3 * static_cast<double>(j)));
    const VectorXd values = codegen::singular_values(observability(a, candidate.transpose() * c));
    const double clarity = values(n - 1) / values(0);
    if (clarity > clearest) {
      clearest = clarity;
      weights = candidate;
    }
  }
  constexpr double kBlind = 1e-10;
  if (!(clearest > kBlind))
    throw KeyError("observer.gain_poles",
                   "[observer] gain_poles: the states cannot all be seen in the outputs, because (A, C) is not "
                   "observable; choose other outputs");
  MatrixXd polynomial = MatrixXd::Identity(n, n);  // prod (A - p I)
  for (const double pole : poles) polynomial = (polynomial * (a - pole * MatrixXd::Identity(n, n))).eval();
  const MatrixXd view = observability(a, weights.transpose() * c);
  const VectorXd last = VectorXd::Unit(n, n - 1);
  return polynomial * codegen::solve(view, last) * weights.transpose();
}

MatrixXd kalman_gain(const MatrixXd& a, const MatrixXd& c, double process_noise, double measurement_noise) {
  const Index n = a.rows();
  MatrixXd hamiltonian(2 * n, 2 * n);
  hamiltonian << a.transpose(), -c.transpose() * c / measurement_noise, -process_noise * MatrixXd::Identity(n, n), -a;
  const codegen::Eigensystem system = codegen::eigensystem(hamiltonian);
  Eigen::MatrixXcd stable(2 * n, n);
  Index found = 0;
  for (Index i = 0; i < 2 * n; ++i) {
    if (system.values(i).real() >= 0.0) continue;
    if (found < n) stable.col(found) = system.vectors.col(i);
    ++found;
  }
  if (found != n)
    throw KeyError("observer.gain_noise",
                   "[observer] gain_noise: there is no stationary Kalman gain, because an unstable or drifting state "
                   "is not observable through A and C; choose other outputs");
  const Eigen::MatrixXcd top = stable.topRows(n).transpose(), bottom = stable.bottomRows(n).transpose();
  const MatrixXd covariance = codegen::solve(top, bottom).transpose().real();
  return covariance * c.transpose() / measurement_noise;
}

LinearPart linear_part(const LuenbergerConfig& config, int nx, int ny, int nu) {
  LinearPart known;
  known.state_matrix = matrix_of("state_matrix", config.state_matrix, nx, nx);
  known.output_matrix = matrix_of("output_matrix", config.output_matrix, ny, nx);
  if (nu == 0 && !config.input_matrix.empty())
    throw KeyError("observer.input_matrix",
                   "[observer] input_matrix needs known inputs, but there are none; remove it, or name inputs");
  known.input_matrix = nu == 0 ? MatrixXd(nx, 0) : matrix_of("input_matrix", config.input_matrix, nx, nu);
  const int given =
      (config.gain.empty() ? 0 : 1) + (config.gain_poles.empty() ? 0 : 1) + (config.gain_noise.empty() ? 0 : 1);
  if (given != 1)
    throw KeyError(
        "observer",
        fmt::format(
            "[observer] has {} of the keys gain, gain_poles and gain_noise; a Luenberger observer needs exactly one",
            given));
  if (!config.gain.empty()) {
    known.gain = matrix_of("gain", config.gain, nx, ny);
  } else if (!config.gain_poles.empty()) {
    if (config.gain_poles.size() != static_cast<std::size_t>(nx))
      throw KeyError("observer.gain_poles",
                     fmt::format("[observer] gain_poles has {} numbers; it must have one for each of the {} states",
                                 config.gain_poles.size(), nx));
    known.gain =
        place_poles(known.state_matrix, known.output_matrix, Eigen::Map<const VectorXd>(config.gain_poles.data(), nx));
  } else {
    if (config.gain_noise.size() != 2)
      throw KeyError("observer.gain_noise", "[observer] gain_noise must be two intensities: [process, measurement]");
    known.gain = kalman_gain(known.state_matrix, known.output_matrix, config.gain_noise[0], config.gain_noise[1]);
  }
  for (const std::complex<double>& lambda :
       codegen::eigenvalues(known.state_matrix - known.gain * known.output_matrix)) {
    if (lambda.real() < 0.0) continue;
    throw KeyError(
        "observer.gain",
        fmt::format(
            "[observer] gain: A - G C has the eigenvalue {}{}{}i, which does not decay; use a larger gain, or let "
            "gain_poles or gain_noise design it",
            shortest_text(lambda.real()), lambda.imag() < 0.0 ? "-" : "+", shortest_text(std::abs(lambda.imag()))));
  }
  return known;
}

}  // namespace nlo::trainer
