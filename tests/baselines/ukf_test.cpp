// SPDX-License-Identifier: MIT
#include "trainer/baselines/ukf.h"

#include <gtest/gtest.h>

#include "trainer/baselines/ekf.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// x' = A x + u with A a chain of n lags; y = the first state, and the sum of all plus u.
FilterPlant linear_plant(Index n) {
  MatrixXd a = -MatrixXd::Identity(n, n);
  for (Index i = 0; i + 1 < n; ++i) a(i, i + 1) = 0.8;
  FilterPlant plant;
  plant.f = [a](const MatrixXd& x) { return MatrixXd(a * x); };
  plant.driven = [a](const MatrixXd& x, const VectorXd& u) {
    return MatrixXd((a * x).colwise() + VectorXd::Constant(x.rows(), u[0]));
  };
  plant.h = [](const MatrixXd& x) { return MatrixXd(x.topRows(1).replicate(2, 1)); };
  plant.driven_output = [](const MatrixXd& x, const VectorXd& u) {
    MatrixXd y(2, x.cols());
    y.row(0) = x.row(0);
    y.row(1) = x.colwise().sum().array() + u[0];
    return y;
  };
  return plant;
}

/// Samples that are 1 to 9 ms apart, as a rig's may be.
VectorXd irregular_times(Index samples) {
  VectorXd time_s(samples);
  for (Index k = 0; k < samples; ++k)
    time_s[k] = k == 0 ? 0.0 : time_s[k - 1] + 0.001 * static_cast<double>(1 + k * k % 9);
  return time_s;
}

FilterConfig config_of(Index n) {
  FilterConfig config{VectorXd::Zero(n), MatrixXd::Identity(n, n), 0.0, Eigen::Vector2d(0.3, 0.1)};
  config.process_noise = VectorXd::LinSpaced(n, 0.2, 0.7);
  return config;
}

double largest_difference(const FilterPlant& plant, const FilterConfig& config) {
  srand(1);  // Eigen's Random
  const MatrixXd y = MatrixXd::Random(2, 80), u = MatrixXd::Random(1, 80);
  const auto make = [&] { return plant; };
  const VectorXd time_s = irregular_times(80);
  return (ukf_estimator(make, config)()(y, u, time_s) - ekf_estimator(make, config)()(y, u, time_s))
      .cwiseAbs()
      .maxCoeff();
}

TEST(Ukf, IsTheKalmanFilterOfALinearPlant) {
  // The EKF's central differences are exact there but for rounding over their step of 6e-6.
  for (const Index n : {1, 2, 3, 5})
    EXPECT_LT(largest_difference(linear_plant(n), config_of(n)), 1e-8) << n << " states";
  FilterPlant bent = linear_plant(2);
  bent.driven_output = {};
  bent.h = [](const MatrixXd& x) { return MatrixXd(x.array().square().matrix()); };
  EXPECT_GT(largest_difference(bent, config_of(2)), 1e-3) << "control: where h bends the two differ";
}

TEST(Ukf, LongSamplePeriodsAreDivided) {
  FilterPlant plant = linear_plant(2);
  plant.longest_step_s = 0.002;
  EXPECT_LT(largest_difference(plant, config_of(2)), 1e-8);
  // A period of 4 s is beyond RK4's stability for x' = -x: one step grows, steps of a tenth do not.
  const auto decayed = [&](double longest_step_s) {
    plant.longest_step_s = longest_step_s;
    return advance(plant, Eigen::Vector2d(1.0, 0.0), 4.0, {}, {})(0, 0);
  };
  EXPECT_NEAR(decayed(0.1), std::exp(-4.0), 1e-5);
  EXPECT_GT(std::abs(decayed(4.0)), 1.0) << "control";
}

TEST(Ukf, AnInitialStateThatIsKnownExactlyStays) {
  FilterConfig config = config_of(2);
  config.initial_covariance.setZero();
  config.process_noise.setZero();
  FilterPlant plant = linear_plant(2);
  const MatrixXd y = MatrixXd::Constant(2, 20, 5.0), u = MatrixXd::Zero(1, 20);
  EXPECT_EQ(ukf_estimator([&] { return plant; }, config)()(y, u, irregular_times(20)).cwiseAbs().maxCoeff(), 0.0);
  config.initial_covariance.setIdentity();
  EXPECT_GT(ukf_estimator([&] { return plant; }, config)()(y, u, irregular_times(20)).cwiseAbs().maxCoeff(), 0.1)
      << "control";
}

TEST(Ukf, TakesTheInnovationOfAnAngleTheShortWayRound) {
  // dx1/dt = x2 = 5 rad/s: an angle that wraps five times in 6 s.
  constexpr double kTurn = 2.0 * 3.141592653589793;
  FilterPlant plant{
      [](const MatrixXd& x) { return MatrixXd((Eigen::Matrix2d() << 0.0, 1.0, 0.0, 0.0).finished() * x); },
      [](const MatrixXd& x) { return MatrixXd(x.topRows<1>()); }};
  const FilterConfig config{Eigen::Vector2d::Zero(), 2.0 * Eigen::Matrix2d::Identity(), 1e-6,
                            VectorXd::Constant(1, 1e-2)};
  const VectorXd time_s = VectorXd::LinSpaced(301, 0.0, 6.0);
  const MatrixXd y = (5.0 * time_s.transpose()).unaryExpr([](double angle) { return std::remainder(angle, kTurn); });
  const auto rate_error = [&] {
    return std::abs(ukf_estimator([&] { return plant; }, config)()(y, {}, time_s)(1, 300) - 5.0);
  };
  const double without = rate_error();
  plant.output_wraps = VectorXd::Constant(1, kTurn);
  EXPECT_LT(rate_error(), 1e-2);
  EXPECT_GT(without, 1.0) << "control: the jumps are large";
}

}  // namespace
}  // namespace nlo::trainer
