// SPDX-License-Identifier: MIT
// A linear plant with irregular samples, and its textbook Kalman filter.
#pragma once

#include <Eigen/Dense>

#include "tests/filters/lanes.h"
#include "trainer/judge/filters/sigma_point_filter.h"

namespace nlo::trainer::test {

/// x' = A x + u, with A a chain of n first-order lags. Outputs: the first state; the sum of all states plus u.
struct Chain {
  explicit Chain(Eigen::Index n) : a(-Eigen::MatrixXd::Identity(n, n)), c(Eigen::MatrixXd::Zero(2, n)) {
    for (Eigen::Index i = 0; i + 1 < n; ++i) a(i, i + 1) = 0.8;
    c(0, 0) = 1.0;
    c.row(1).setOnes();
  }

  LanePlant plant() const {
    LanePlant known;
    known.nx = a.rows();
    known.ny = 2;
    known.output_wraps = Eigen::Vector2d::Zero();
    known.f = [a = a](const Eigen::MatrixXd& x, const Eigen::MatrixXd& u) {
      return Eigen::MatrixXd(a * x + u.replicate(a.rows(), 1));
    };
    known.h = [c = c](const Eigen::MatrixXd& x, const Eigen::MatrixXd& u) {
      Eigen::MatrixXd y = c * x;
      y.row(1) += u;
      return y;
    };
    return known;
  }
  Eigen::MatrixXd a, c;
};

/// Returns knowledge with a full P0, process noise per second, and different noise of the two outputs.
inline FilterKnowledge chain_knowledge(Eigen::Index n) {
  const Eigen::MatrixXd root = Eigen::MatrixXd::Identity(n, n) + 0.3 * normals(n, n, 5);
  return {Eigen::VectorXd::Constant(n, 0.2),
          root * root.transpose(),
          Eigen::VectorXd::Constant(n, 0.01),
          Eigen::Vector2d(0.55, 0.3),
          {},
          Eigen::VectorXd::LinSpaced(n, 0.2, 0.7)};
}

/// Samples 1 to 9 ms apart, as in real logs; arbitrary inputs and outputs, which no plant produced.
struct IrregularRun {
  static constexpr Eigen::Index kSamples = 80;
  IrregularRun() : time_s(kSamples), y(normals(2, kSamples, 1)), u(normals(1, kSamples, 2)) {
    for (Eigen::Index k = 0; k < kSamples; ++k)
      time_s[k] = k == 0 ? 0.0 : time_s[k - 1] + 0.001 * double(1 + k * k % 9);
  }
  Eigen::VectorXd time_s;
  Eigen::MatrixXd y, u;
};

/// Textbook Kalman recursion with covariances and one gain for all outputs.
inline Eigen::MatrixXd kalman_recursion(const Chain& chain, const FilterKnowledge& known, const IrregularRun& run,
                                        bool held) {
  const Eigen::Index n = chain.a.rows();
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(n, n), r = known.output_deviation.cwiseAbs2().asDiagonal();
  Eigen::VectorXd x = known.initial_state;
  Eigen::MatrixXd p = known.initial_covariance, all(n, IrregularRun::kSamples);
  for (Eigen::Index k = 0; k < IrregularRun::kSamples; ++k) {
    if (k > 0) {
      const double h = run.time_s[k] - run.time_s[k - 1];
      const Eigen::MatrixXd ah = h * chain.a, phi = one + ah * (one + ah / 2.0 * (one + ah / 3.0 * (one + ah / 4.0)));
      const Eigen::VectorXd from = Eigen::VectorXd::Constant(n, run.u(0, held ? k : k - 1)),
                            to = Eigen::VectorXd::Constant(n, run.u(0, k));
      // RK4 of x' = A x + u for a ramp u: the integral of exp(A (h - s)) (from + (to - from) s / h) up to h^4.
      x = phi * x + h * (one + ah / 2.0 * (one + ah / 3.0 * (one + ah / 4.0))) * from +
          h * (one / 2.0 + ah / 6.0 * (one + ah / 4.0)) * (to - from);
      p = phi * p * phi.transpose();
      p.diagonal() += known.process_deviation.cwiseAbs2() + h * known.process_noise.cwiseAbs2();
    }
    const Eigen::Vector2d innovation = run.y.col(k) - chain.c * x - Eigen::Vector2d(0.0, run.u(0, k));
    const Eigen::MatrixXd gain = p * chain.c.transpose() * (chain.c * p * chain.c.transpose() + r).inverse();
    x += gain * innovation;
    p = ((one - gain * chain.c) * p).eval();
    all.col(k) = x;
  }
  return all;
}

}  // namespace nlo::trainer::test
