// SPDX-License-Identifier: MIT
#include "trainer/structures/observer_gain.h"
#include "codegen/base/linear_algebra.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "tests/support/thrown_message.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

std::vector<double> real_parts(const MatrixXd& m) {
  const Eigen::VectorXcd values = codegen::eigenvalues(m);
  std::vector<double> parts;
  for (const auto& value : values) parts.push_back(value.real());
  std::sort(parts.begin(), parts.end());
  return parts;
}

MatrixXd chain(int n) {
  MatrixXd a = MatrixXd::Zero(n, n);
  for (int i = 0; i + 1 < n; ++i) a(i, i + 1) = 1.0;
  for (int i = 0; i < n; ++i) a(n - 1, i) = 0.3 * i - 1.0;
  return a;
}

TEST(ObserverGain, PlacesEveryPole) {
  for (const int n : {1, 2, 4}) {
    for (const int outputs : {1, 2}) {
      if (outputs > n) continue;
      MatrixXd c = MatrixXd::Zero(outputs, n);
      c(0, 0) = 1.0;
      if (outputs == 2) c(1, n - 1) = 2.0;
      VectorXd poles(n);
      for (int i = 0; i < n; ++i) poles(i) = -1.0 - i;
      const MatrixXd gain = place_poles(chain(n), c, poles);
      const std::vector<double> placed = real_parts(chain(n) - gain * c);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(placed[static_cast<std::size_t>(i)], poles(n - 1 - i), 1e-8);  // Ackermann's formula in double
    }
  }
}

TEST(ObserverGain, RefusesWhatTheOutputsCannotSee) {
  const MatrixXd a = MatrixXd::Identity(2, 2);  // two equal modes, one output
  EXPECT_THAT(thrown_message([&] { place_poles(a, MatrixXd::Ones(1, 2), VectorXd::Constant(2, -1.0)); }),
              HasSubstr("cannot all be seen"));
}

TEST(ObserverGain, KalmanGainOfAScalarPlantIsItsClosedForm) {
  // x' = a x + w, y = c x + v: p = (a + sqrt(a^2 + c^2 q / r)) r / c^2, g = p c / r.
  const double a = 0.7, c = 2.0, q = 0.5, r = 0.1;
  const double expected = (a + std::sqrt(a * a + c * c * q / r)) / c;
  const MatrixXd gain = kalman_gain(MatrixXd::Constant(1, 1, a), MatrixXd::Constant(1, 1, c), q, r);
  EXPECT_NEAR(gain(0, 0), expected, 1e-12 * expected);
}

TEST(ObserverGain, KalmanGainSolvesTheRiccatiEquation) {
  const MatrixXd a = chain(3);
  MatrixXd c(2, 3);
  c << 1.0, 0.0, 0.5, 0.0, 1.0, 0.0;
  const double q = 0.3, r = 0.2;
  const MatrixXd gain = kalman_gain(a, c, q, r);
  EXPECT_LT(real_parts(a - gain * c).back(), 0.0);
  // G = P C^T / r determines P C^T only; check through the Lyapunov form (A - G C) P + P (A - G C)^T = -(q I + r G
  // G^T).
  const MatrixXd closed = a - gain * c;
  MatrixXd kronecker = MatrixXd::Zero(9, 9);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      kronecker.block(3 * i, 3 * j, 3, 3) += closed(i, j) * MatrixXd::Identity(3, 3);
      if (i == j) kronecker.block(3 * i, 3 * j, 3, 3) += closed;
    }
  const MatrixXd right = -(q * MatrixXd::Identity(3, 3) + r * gain * gain.transpose());
  const VectorXd solution = codegen::solve(kronecker, Eigen::Map<const VectorXd>(right.data(), 9));
  const MatrixXd covariance = Eigen::Map<const MatrixXd>(solution.data(), 3, 3);
  EXPECT_LT((covariance * c.transpose() / r - gain).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ObserverGain, RefusesAGainThatDoesNotDecay) {
  LuenbergerConfig config;
  config.state_matrix = {{0.0, 1.0}, {-1.0, 0.0}};
  config.output_matrix = {{1.0, 0.0}};
  config.gain = {{-1.0}, {0.0}};
  EXPECT_THAT(thrown_message([&] { linear_part(config, 2, 1); }), HasSubstr("does not decay"));
}

}  // namespace
}  // namespace nlo::trainer
