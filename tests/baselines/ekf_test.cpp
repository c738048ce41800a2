// SPDX-License-Identifier: MIT
#include "trainer/baselines/ekf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/evaluation/van_der_pol_set.h"

namespace nlo::trainer {
namespace {

double ekf_norm(const Dataset& set, const NoiseConfig& noise) {
  const FilterConfig config = ekf_config(Eigen::Vector2d(-1.0, -1.0), Eigen::Vector2d(1.0, 1.0), noise);
  return evaluate("ekf", ekf_estimator(test::van_der_pol_for_ekf, config), set, noise, 11, 0).metrics.norm;
}

// What an independent prototype measured with the exact model, Q = 1e-6, 200 runs of 50 s: the reference values of the
// protocol. The band covers another draw of the initial states and of the noise, which the first second dominates.
struct Reference {
  NoiseConfig noise;
  double norm, tolerance;
};

class EkfReference : public testing::TestWithParam<Reference> {};

TEST_P(EkfReference, MeetsTheProtocolsTable) {
  const auto& [noise, norm, tolerance] = GetParam();
  EXPECT_NEAR(ekf_norm(test::van_der_pol_set(200, 50.0, 5), noise), norm, tolerance * norm);
}

INSTANTIATE_TEST_SUITE_P(VanDerPol, EkfReference,
                         testing::Values(Reference{{}, 0.0148, 0.10},
                                         Reference{{NoiseKind::kGaussian, 0.5}, 0.0944, 0.10},
                                         Reference{{NoiseKind::kUniform, 3.0}, 0.2222, 0.10}));

TEST(Ekf, LinearPlantMeetsTheScalarKalmanRecursion) {
  // dx/dt = -x, y = x: phi = RK4's polynomial in -h; the scalar recursion in closed form beside the filter.
  constexpr double kStep = 0.1, kP0 = 2.0, kQ = 1e-6, kR = 0.3;
  const double phi = 1.0 - kStep + kStep * kStep / 2 - std::pow(kStep, 3) / 6 + std::pow(kStep, 4) / 24;
  const FilterPlant plant{[](const Eigen::MatrixXd& x) { return Eigen::MatrixXd(-x); },
                          [](const Eigen::MatrixXd& x) { return x; }};
  const FilterConfig config{Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Constant(1, 1, kP0), kQ,
                            Eigen::VectorXd::Constant(1, kR)};
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(50, 0.0, 4.9);
  const Eigen::MatrixXd y = Eigen::MatrixXd::Random(1, 50);
  const Eigen::MatrixXd estimate = ekf_estimator([&] { return plant; }, config)()(y, {}, time_s);
  double x = 0.0, p = kP0;
  for (Eigen::Index k = 0; k < 50; ++k) {
    if (k > 0) {
      x *= phi;
      p = phi * phi * p + kQ;
    }
    const double gain = p / (p + kR);
    x += gain * (y(0, k) - x);
    p *= 1.0 - gain;
    // Central differences of a linear map are exact but for rounding over their step of 6e-6.
    ASSERT_NEAR(estimate(0, k), x, 1e-9) << k;
  }
}

TEST(Ekf, TrustsEachOutputByItsOwnNoise) {
  // Two sensors of one state, the second so noisy that it says nothing: the estimate is that of the first alone.
  const auto plant = [](Eigen::Index outputs) {
    return FilterPlant{[](const Eigen::MatrixXd& x) { return Eigen::MatrixXd(-x); },
                       [outputs](const Eigen::MatrixXd& x) { return Eigen::MatrixXd(x.replicate(outputs, 1)); }};
  };
  const auto estimate = [&](const Eigen::MatrixXd& y, const Eigen::VectorXd& variance) {
    const FilterConfig config{Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Identity(1, 1), 1e-6, variance};
    const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(y.cols(), 0.0, 2.0);
    return Eigen::MatrixXd(ekf_estimator([&] { return plant(y.rows()); }, config)()(y, {}, time_s));
  };
  const Eigen::MatrixXd y = Eigen::MatrixXd::Random(2, 40);
  const Eigen::MatrixXd first = estimate(y.row(0), Eigen::VectorXd::Constant(1, 0.3));
  EXPECT_LE((estimate(y, Eigen::Vector2d(0.3, 1e9)) - first).cwiseAbs().maxCoeff(), 1e-7);
  EXPECT_GT((estimate(y, Eigen::VectorXd::Constant(1, 0.3)) - first).cwiseAbs().maxCoeff(), 0.1) << "control";
}

TEST(Ekf, TakesTheInnovationOfAnAngleTheShortWayRound) {
  // dx1/dt = x2 = 5 rad/s: an angle that wraps five times in 6 s.
  constexpr double kTurn = 2.0 * 3.141592653589793;
  FilterPlant plant{[](const Eigen::MatrixXd& x) {
                      return Eigen::MatrixXd((Eigen::Matrix2d() << 0.0, 1.0, 0.0, 0.0).finished() * x);
                    },
                    [](const Eigen::MatrixXd& x) { return Eigen::MatrixXd(x.topRows<1>()); }};
  const FilterConfig config{Eigen::Vector2d::Zero(), 30.0 * Eigen::Matrix2d::Identity(), 1e-6,
                            Eigen::VectorXd::Constant(1, 1e-2)};
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(301, 0.0, 6.0);
  const Eigen::MatrixXd y =
      (5.0 * time_s.transpose()).unaryExpr([](double angle) { return std::remainder(angle, kTurn); });
  const auto rate_error = [&] {
    return std::abs(ekf_estimator([&] { return plant; }, config)()(y, {}, time_s)(1, 300) - 5.0);
  };
  const double without = rate_error();
  plant.output_wraps = Eigen::VectorXd::Constant(1, kTurn);
  EXPECT_LT(rate_error(), 1e-3);
  EXPECT_GT(without, 1.0) << "control: the jumps are large";
}

TEST(Ekf, KnowsTheInputThatExcitesThePlant) {
  // dx1/dt = x2, dx2/dt = -x1 + cos 3t from rest: x1 = (cos t - cos 3t) / 8.
  constexpr double kStep = 0.02;
  constexpr Eigen::Index kSamples = 1001;
  Dataset set{{{"y", "", 0.0}}, {{"x1", "", 0.0}, {"x2", "", 0.0}}, kStep, true, {Trajectory()}};
  Trajectory& run = set.trajectories[0];
  run.time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, kStep * (kSamples - 1));
  const Eigen::RowVectorXd t = run.time_s.transpose();
  run.inputs = (3.0 * t.array()).cos().matrix();
  run.states.resize(2, kSamples);
  run.states.row(0) = (t.array().cos() - (3.0 * t.array()).cos()) / 8.0;
  run.states.row(1) = (3.0 * (3.0 * t.array()).sin() - t.array().sin()) / 8.0;
  run.outputs = run.states.topRows<1>();
  run.weight = Eigen::VectorXd::Ones(kSamples);

  FilterPlant plant{[](const Eigen::MatrixXd& x) {
                      return Eigen::MatrixXd((Eigen::Matrix2d() << 0.0, 1.0, -1.0, 0.0).finished() * x);
                    },
                    [](const Eigen::MatrixXd& x) { return Eigen::MatrixXd(x.topRows<1>()); }};
  const FilterConfig config{Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity(), 1e-6,
                            Eigen::VectorXd::Constant(1, 1e-2)};
  const auto norm = [&] {
    return evaluate("ekf", ekf_estimator([&] { return plant; }, config), set, {}, 1, 1).metrics.norm;
  };
  const double without = norm();
  plant.driven = [f = plant.f](const Eigen::MatrixXd& x, const Eigen::VectorXd& u) {
    return Eigen::MatrixXd(f(x).colwise() + Eigen::Vector2d(0.0, u(0)));
  };
  EXPECT_LT(norm(), std::pow(3.0 * kStep, 2) / 12.0);  // the ramp's error in u, of amplitude 1; it acts as 1/8 of that
  EXPECT_GT(without, 0.1) << "control: the drive is large";
}

TEST(Ekf, KnowsHowAnInputIsHeld) {
  // dx/dt = -x + u with a u that turns its sign at every tenth sample, held over the period before each: the recursion
  // x_k = phi x_{k-1} + (1 - phi) u_k is exact, phi by RK4. A filter that is sure of x(0) must stay on it.
  constexpr double kStep = 0.1;
  constexpr Eigen::Index kSamples = 60;
  const double phi = 1.0 - kStep + kStep * kStep / 2 - std::pow(kStep, 3) / 6 + std::pow(kStep, 4) / 24;
  Eigen::MatrixXd u(1, kSamples), x = Eigen::MatrixXd::Zero(1, kSamples);
  for (Eigen::Index k = 0; k < kSamples; ++k) u(0, k) = k / 10 % 2 == 0 ? 1.0 : -1.0;
  for (Eigen::Index k = 1; k < kSamples; ++k) x(0, k) = phi * x(0, k - 1) + (1.0 - phi) * u(0, k);
  const FilterPlant plant{
      [](const Eigen::MatrixXd& at) { return Eigen::MatrixXd(-at); }, [](const Eigen::MatrixXd& at) { return at; },
      [](const Eigen::MatrixXd& at, const Eigen::VectorXd& input) { return Eigen::MatrixXd((-at).colwise() + input); }};
  const auto worst = [&](bool held) {
    FilterConfig config{Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Constant(1, 1, 1e-12), 1e-12,
                        Eigen::VectorXd::Constant(1, 1e6)};  // the output says nothing: u alone moves the estimate
    config.held_inputs = held;
    const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(kSamples, 0.0, kStep * (kSamples - 1));
    return (ekf_estimator([&] { return plant; }, config)()(x, u, time_s) - x).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(worst(true), 1e-12);
  EXPECT_GT(worst(false), 0.05) << "control: a ramp over each change is half a step off";
}

TEST(Ekf, AddsThePlantsOwnNoiseToItsModel) {
  // dx/dt = 0, y = x: the scalar recursion p -> p + sigma^2 h, K = p / (p + R), p -> (1 - K) p.
  constexpr double kStep = 0.1, kSigma = 0.7, kR = 0.3;
  const FilterPlant plant{[](const Eigen::MatrixXd& x) { return Eigen::MatrixXd::Zero(x.rows(), x.cols()).eval(); },
                          [](const Eigen::MatrixXd& x) { return x; }};
  const FilterConfig config{Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Identity(1, 1), 0.0,
                            Eigen::VectorXd::Constant(1, kR), Eigen::VectorXd::Constant(1, kSigma)};
  const Eigen::VectorXd time_s = Eigen::VectorXd::LinSpaced(30, 0.0, 2.9);
  const Eigen::MatrixXd y = Eigen::MatrixXd::Random(1, 30);
  const Eigen::MatrixXd estimate = ekf_estimator([&] { return plant; }, config)()(y, {}, time_s);
  double x = 0.0, p = 1.0;
  for (Eigen::Index k = 0; k < 30; ++k) {
    if (k > 0) p += kSigma * kSigma * kStep;
    const double gain = p / (p + kR);
    x += gain * (y(0, k) - x);
    p *= 1.0 - gain;
    ASSERT_NEAR(estimate(0, k), x, 1e-9) << k;  // central differences of a linear map: rounding over their step
  }
}

}  // namespace
}  // namespace nlo::trainer
