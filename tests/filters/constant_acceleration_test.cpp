// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/constant_acceleration.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "trainer/judge/filters/plant_equations.h"
#include "trainer/plants/equations_of_plant.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Response of [p v a] after t seconds to a unit initial value of p, v or a, or to a unit impulse of jerk.
Vector3d response(int of, double t) {
  if (of == 0) return {1.0, 0.0, 0.0};
  if (of == 1) return {t, 1.0, 0.0};
  return {0.5 * t * t, t, 1.0};
}

/// cov(x(s), x(t)) of the process with the initial covariance of the filter: the part of the initial state, and the
/// part of the jerk by Simpson's rule with 2,000 intervals, which is exact up to the third degree.
Eigen::Matrix3d covariance(const Vector3d& start, double q, double s, double t) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (int i = 0; i < 3; ++i) sum += start[i] * response(i, s) * response(i, t).transpose();
  constexpr int kIntervals = 2000;
  const double end = std::min(s, t), h = end / kIntervals;
  for (int k = 0; k <= kIntervals; ++k) {
    const double weight = (k == 0 || k == kIntervals ? 1.0 : k % 2 == 1 ? 4.0 : 2.0) * h / 3.0;
    sum += q * weight * response(2, s - k * h) * response(2, t - k * h).transpose();
  }
  return sum;
}

/// Returns the last estimate of the filter as the mean of a Gaussian distribution conditioned on all measurements at
/// once.
Vector3d conditional_mean(const ConstantAcceleration& filter, const VectorXd& time_s, const VectorXd& y) {
  const double q = filter.jerk_intensity, r = filter.output_variance, tau = std::pow(r / q, 0.2);
  const double v = 1e3 * std::sqrt(r) / tau;
  const Vector3d start(r, v * v, v * v / (tau * tau));
  const Index n = y.size() - 1;
  MatrixXd s(n, n), cross(3, n);
  for (Index i = 0; i < n; ++i) {
    for (Index j = 0; j < n; ++j)
      s(i, j) = covariance(start, q, time_s[i + 1], time_s[j + 1])(0, 0) + (i == j ? r : 0.0);
    cross.col(i) = covariance(start, q, time_s[n], time_s[i + 1]).col(0);
  }
  return Vector3d(y[0], 0.0, 0.0) + cross * s.fullPivLu().solve((y.tail(n).array() - y[0]).matrix());
}

const VectorXd kTimes = (VectorXd(8) << 0.0, 0.003, 0.011, 0.013, 0.021, 0.022, 0.030, 0.034).finished();

VectorXd swing(const VectorXd& time_s) {
  return (40.0 * time_s.array()).sin() + 0.01 * (900.0 * time_s.array()).cos();
}

TEST(ConstantAcceleration, IsTheConditionalMeanAtIrregularSamples) {
  const ConstantAcceleration filter{1e7, 1e-4};
  const VectorXd y = swing(kTimes);
  const Vector3d last = filter.estimate(kTimes, y).rightCols<1>(), closed = conditional_mean(filter, kTimes, y);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(last[i], closed[i], 1e-6 * std::abs(closed[i]) + 1e-9) << i;
  const VectorXd even = VectorXd::LinSpaced(8, 0.0, 0.034);
  const Vector3d stamps_ignored = filter.estimate(even, y).rightCols<1>();
  EXPECT_GT(std::abs(stamps_ignored[1] - closed[1]), 0.01 * std::abs(closed[1])) << "control: the steps matter";
}

TEST(ConstantAcceleration, DependsOnlyOnTheRatioOfItsNoises) {
  const VectorXd y = swing(kTimes);
  const MatrixXd estimates = ConstantAcceleration{1e7, 1e-4}.estimate(kTimes, y);
  EXPECT_LT((ConstantAcceleration{1e11, 1.0}.estimate(kTimes, y) - estimates).cwiseAbs().maxCoeff(),
            1e-9 * estimates.cwiseAbs().maxCoeff());
  EXPECT_GT((ConstantAcceleration{1e9, 1e-4}.estimate(kTimes, y) - estimates).cwiseAbs().maxCoeff(), 1e-2) << "control";
}

TEST(ConstantAcceleration, FollowsAnAngleThatWraps) {
  const VectorXd time_s = VectorXd::LinSpaced(400, 0.0, 2.0);
  const VectorXd y = (700.0 * time_s.array()).unaryExpr([](double angle) { return std::remainder(angle, 360.0); });
  ConstantAcceleration filter{1e6, 1e-2};
  EXPECT_GT(std::abs(filter.estimate(time_s, y)(1, 399) - 700.0), 1.0) << "control";
  filter.wrap = 360.0;
  EXPECT_NEAR(filter.estimate(time_s, y)(1, 399), 700.0, 1e-3);
}

constexpr double kRounding = 1e-12;

PlantConfig builtin(std::string_view name) {
  PlantConfig config;
  config.model = name;
  return config;
}

TEST(PlantEquations, EqualTheBuiltInPlants) {
  const MatrixXd x = MatrixXd::Random(2, 20), u = MatrixXd::Random(1, 20);
  for (const PlantEntry& entry : plant_registry()) {
    PlantConfig config = builtin(entry.name);
    for (const auto& [name, value] : entry.parameters) config.parameters.emplace_back(name, 1.3 * value);
    const auto plant = make_plant(config), written = make_plant(equations_of(config));
    EXPECT_LE((plant->derivative(x) - written->derivative(x)).norm(), kRounding) << entry.name;
    EXPECT_LE((plant->output(x) - written->output(x)).norm(), kRounding) << entry.name;
    ASSERT_EQ(plant->nu(), written->nu()) << entry.name;
    if (plant->nu() == 0) continue;
    EXPECT_LE((plant->driven_derivative(x, u) - written->driven_derivative(x, u)).norm(), kRounding) << entry.name;
  }
}

TEST(JointPlant, UsesTheParametersOfEachColumn) {
  // The plant is affine in mu, so the joint plant uses a difference of plants. It is quadratic in omega, so the joint
  // plant uses expressions.
  for (const auto& [model, name] : {std::pair{"van_der_pol", "mu"}, std::pair{"harmonic_oscillator", "omega"}}) {
    const LanePlant joint = joint_plant(builtin(model), {name}, MatrixXd::Random(2, 5));
    ASSERT_EQ(joint.nx, 3) << model;
    MatrixXd points(3, 4);
    points << MatrixXd::Random(2, 4), Eigen::RowVector4d(0.5, 1.0, 1.6, 3.0);
    const MatrixXd f = joint.f(points, MatrixXd());
    for (Eigen::Index i = 0; i < 4; ++i) {
      PlantConfig own = builtin(model);
      own.parameters = {{name, points(2, i)}};
      EXPECT_LE((f.col(i).head(2) - make_plant(own)->derivative(points.col(i).head(2))).norm(), kRounding) << model;
      EXPECT_EQ(f(2, i), 0.0) << model;
      EXPECT_EQ(joint.h(points, MatrixXd())(0, i), points(0, i)) << model;
    }
  }
}

}  // namespace
}  // namespace nlo::trainer
