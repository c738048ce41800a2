// SPDX-License-Identifier: MIT
// T from the plant: compared with the Sylvester equation for linear plants, and with its own equation (5) for others.
#include "trainer/prove/forward_map.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "codegen/base/error.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/prove/lipschitz.h"

namespace nlo::trainer {
namespace {

/// Two real modes, a complex pair and a clock.
LatentSystem mixed_system() {
  LatentSystem system;
  system.eigenvalues = Eigen::Vector<double, 5>(-0.6, 0.9, -1.0, -4.0, -2.0);
  system.pairs = 1;
  system.injection = Eigen::Vector<double, 5>(1.0, 0.5, 1.0, 2.0, 0.0);
  return system;
}

LinearPlant oscillator() {
  Eigen::Matrix2d a;
  a << 0.0, 1.0, -1.7, 0.0;
  return {"oscillator", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.3)};
}

std::unique_ptr<Plant> van_der_pol() {
  PlantConfig config;
  config.model = "van_der_pol";
  return make_plant(config);
}

const MapDomain kOscillatorDomain{Eigen::Vector2d::Zero(), Eigen::Vector2d(2.0, 2.0)};
const MapDomain kVanDerPolDomain{Eigen::Vector2d::Zero(), Eigen::Vector2d(2.0, 2.7)};

/// A grid over [-1, 1]^2, 2 x 25.
Eigen::MatrixXd grid() {
  Eigen::MatrixXd x(2, 25);
  for (int i = 0; i < 25; ++i) x.col(i) << -1.0 + 0.5 * (i % 5), -1.0 + 0.5 * (i / 5);
  return x;
}

/// k D, as in Proposition 2.
LatentSystem faster(LatentSystem system, double k) {
  system.eigenvalues *= k;
  return system;
}

TEST(SylvesterMap, SolvesTheEquationOfT) {
  constexpr double kRounding = 1e-13;
  const LinearPlant plant = oscillator();
  const LatentSystem system = mixed_system();
  const Eigen::MatrixXd t = sylvester_map(plant.a(), plant.c(), system);
  const Eigen::MatrixXd residual = t * plant.a() - apply_d(system, t) - system.injection * plant.c();
  EXPECT_LT(residual.cwiseAbs().maxCoeff(), kRounding);
  EXPECT_TRUE(t.row(4).isZero(0.0)) << "a clock does not depend on the plant";
}

TEST(SylvesterMap, RefusesAnEigenvalueOfThePlant) {
  LatentSystem system;
  system.eigenvalues = Eigen::VectorXd::Constant(1, -2.0);
  system.injection = Eigen::MatrixXd::Ones(1, 1);
  EXPECT_THROW(sylvester_map(Eigen::MatrixXd::Constant(1, 1, -2.0), Eigen::MatrixXd::Ones(1, 1), system),
               codegen::Error);
  EXPECT_NO_THROW(sylvester_map(Eigen::MatrixXd::Constant(1, 1, -1.0), Eigen::MatrixXd::Ones(1, 1), system));
}

TEST(ForwardMap, EqualsTheSylvesterSolutionForALinearPlant) {
  constexpr double kTruncation = 2e-7;  // 1e-7 of the past is cut off, relative to |F y| / |lambda|
  const LinearPlant plant = oscillator();
  const ForwardMap map(plant, mixed_system(), kOscillatorDomain);
  const Eigen::MatrixXd exact = sylvester_map(plant.a(), plant.c(), mixed_system()), x = grid();
  EXPECT_LT((map.at(x) - exact * x).cwiseAbs().maxCoeff(), kTruncation * (exact * x).cwiseAbs().maxCoeff());
  for (const Eigen::MatrixXd& jacobian : map.jacobians(x.leftCols(3)))
    EXPECT_LT((jacobian - exact).norm(), 1e-6 * exact.norm());
}

TEST(ForwardMap, IsOfFourthOrderInTheStep) {
  const LinearPlant plant = oscillator();
  LatentSystem system = mixed_system();
  system.eigenvalues(3) = -2.5;  // keeps |lambda h| where the order can be measured
  const Eigen::MatrixXd exact = sylvester_map(plant.a(), plant.c(), system), x = grid();
  const auto error = [&](double step_s) {
    ForwardMapOptions options;
    options.longest_step_s = step_s;
    options.step_per_time = 10.0;
    options.truncation = 1e-13;
    return (ForwardMap(plant, system, kOscillatorDomain, options).at(x) - exact * x).norm();
  };
  const double coarse = error(0.2), middle = error(0.1), fine = error(0.05);
  EXPECT_NEAR(std::log2(coarse / middle), 4.0, 0.4);
  EXPECT_NEAR(std::log2(middle / fine), 4.0, 0.3);
}

TEST(ForwardMap, JacobiansAreOfSecondOrderInTheDifferenceStep) {
  const auto plant = van_der_pol();
  const ForwardMap map(*plant, mixed_system(), kVanDerPolDomain);
  const Eigen::MatrixXd x = grid().middleCols(6, 3);
  const auto reference = map.jacobians(x, 1e-3);
  const auto error = [&](double step) {
    double sum = 0.0;
    const auto jacobians = map.jacobians(x, step);
    for (std::size_t i = 0; i < jacobians.size(); ++i) sum += (jacobians[i] - reference[i]).squaredNorm();
    return std::sqrt(sum);
  };
  const double coarse = error(0.08), middle = error(0.04), fine = error(0.02);
  EXPECT_NEAR(std::log2(coarse / middle), 2.0, 0.25);
  EXPECT_NEAR(std::log2(middle / fine), 2.0, 0.15);
}

TEST(ForwardMap, SolvesThePdeOfVanDerPolInsideTheBox) {
  constexpr double kSmall = 1e-5;  // difference step 1e-4, truncation 1e-7 over that step
  const auto plant = van_der_pol();
  const Eigen::MatrixXd x = grid();
  const ForwardMap map(*plant, mixed_system(), kVanDerPolDomain);
  EXPECT_LT(map.pde_residual(x).maxCoeff(), kSmall);

  ForwardMapOptions forgetful;  // control: a T that uses too little of the past does not solve it
  forgetful.truncation = 0.3;
  EXPECT_GT(ForwardMap(*plant, mixed_system(), kVanDerPolDomain, forgetful).pde_residual(x).maxCoeff(), 100.0 * kSmall);
}

TEST(ForwardMap, ExistsAndSolvesThePdeIfThePlantEscapesBackwards) {
  const auto plant = van_der_pol();
  Eigen::MatrixXd x(2, 2);  // outside of the limit cycle, within O
  x << 2.6, -1.0, 2.0, 3.6;
  const LatentSystem fast = faster(mixed_system(), 4.0);
  const ForwardMap map(*plant, fast, kVanDerPolDomain);
  EXPECT_TRUE(map.at(x).allFinite());
  EXPECT_LT(map.pde_residual(x).maxCoeff(), 1e-3 * (fast.injection * plant->output(x)).norm());
  Eigen::MatrixXd escaped = x;  // control: without the switch the plant escapes
  for (int i = 0; i < 2000 && escaped.allFinite(); ++i) escaped = rk4_step(*plant, escaped, -0.01);
  EXPECT_FALSE(escaped.allFinite());
}

TEST(ForwardMap, ForwardAndBackwardIntegrationAgreeAlongARun) {
  constexpr double kSame = 1e-6;
  const auto plant = van_der_pol();
  const ForwardMap map(*plant, mixed_system(), kVanDerPolDomain);
  const ForwardMap::Path path = map.along(grid().leftCols(4), 0.02, 151);
  ASSERT_EQ(path.x.size(), 151u);
  for (const std::size_t k : {std::size_t{0}, std::size_t{50}, std::size_t{150}})
    EXPECT_LT((map.at(path.x[k]) - path.z[k]).norm(), kSame * (1.0 + path.z[k].norm())) << "at sample " << k;
}

TEST(ForwardMap, SlopesFallAboutAsOneOverK) {
  constexpr double kAsymptotic = 0.15;  // the next term is of order f'(x) / (k lambda)
  const auto plant = van_der_pol();
  const auto scaled_slope = [&](double k) {
    double largest = 0.0;
    for (const Eigen::MatrixXd& jacobian :
         ForwardMap(*plant, faster(mixed_system(), k), kVanDerPolDomain).jacobians(grid()))
      largest = std::max(largest, spectral_norm(jacobian));
    return k * largest;
  };
  const double at_8 = scaled_slope(8.0), at_16 = scaled_slope(16.0);
  EXPECT_NEAR(at_16 / at_8, 1.0, kAsymptotic);
}

}  // namespace
}  // namespace nlo::trainer
