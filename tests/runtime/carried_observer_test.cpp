// SPDX-License-Identifier: MIT
// Vectors carried by a rotation: exact where the solution is known, of order four elsewhere, and equal for any
// orientation of the sensor's axes.
#include <nlo/carried_observer.h>

#include <gtest/gtest.h>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/runtime/linear_oracles.h"
#include "tests/runtime/structures.h"

namespace nlo {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using testing::carried_model;

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Vector3d random_vector(std::mt19937& random, double size) {
  return {testing::uniform<double>(random, -size, size), testing::uniform<double>(random, -size, size),
          testing::uniform<double>(random, -size, size)};
}

template <class Scalar>
Vector<Scalar, 3> vector(const Vector3d& v) {
  return {{static_cast<Scalar>(v.x()), static_cast<Scalar>(v.y()), static_cast<Scalar>(v.z())}};
}

template <class Scalar>
Vector3d eigen(const Vector<Scalar, 3>& v) {
  return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

template <class Scalar, int kDoublings>
double rotation_error(const Vector3d& theta) {
  const Scalar given[3] = {static_cast<Scalar>(theta.x()), static_cast<Scalar>(theta.y()),
                           static_cast<Scalar>(theta.z())};
  const auto rotation = Rotation<Scalar>::template of<kDoublings>(given);
  const Vector3d rounded(static_cast<double>(given[0]), static_cast<double>(given[1]), static_cast<double>(given[2]));
  const Matrix3d exact = testing::exponential(-cross_matrix(rounded));
  double worst = 0.0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      worst =
          std::max(worst, std::abs(static_cast<double>(rotation.minus_1[i][j]) + (i == j ? 1.0 : 0.0) - exact(i, j)));
  return worst / static_cast<double>(std::numeric_limits<Scalar>::epsilon());
}

TEST(Rotation, IsTheMatrixExponentialForAnyAngle) {
  constexpr double kRoundings = 4.0, kPerRadian = 45.0;  // two roundings of the angle per doubling
  std::mt19937 random(1);
  for (const double size : {0.0, 1e-20, 1e-9, 1e-4, 0.03, 0.5, 1.7, 4.0}) {
    for (int k = 0; k < 100; ++k) {
      const Vector3d theta = random_vector(random, size);
      const double limit = kRoundings + kPerRadian * theta.norm();
      ASSERT_LT((rotation_error<float, 3>(theta)), limit) << theta.transpose();
      ASSERT_LT((rotation_error<double, 3>(theta)), limit) << theta.transpose();
      ASSERT_LT((rotation_error<float, 21>(theta)), limit) << theta.transpose();
      ASSERT_LT((rotation_error<double, 21>(100.0 * theta)), kRoundings + 100.0 * kPerRadian * theta.norm());
    }
  }
}

TEST(MakeUnit, IsExactToRoundingForVectorsOfAnySize) {
  const auto check = []<class Scalar>(Scalar) {
    constexpr double kRoundings = 4.0;
    std::mt19937 random(2);
    for (int k = 0; k < 2000; ++k) {
      const Vector3d v = random_vector(random, 1.0);
      const int exponent = static_cast<int>(random() % 200) - 100;
      Scalar given[3], unit[3];
      for (int i = 0; i < 3; ++i)
        given[i] = unit[i] = std::ldexp(k % 7 == i ? Scalar(0) : static_cast<Scalar>(v[i]), exponent);
      make_unit(unit);
      const Vector3d exact(static_cast<double>(given[0]), static_cast<double>(given[1]), static_cast<double>(given[2]));
      for (int i = 0; i < 3; ++i)
        ASSERT_NEAR(static_cast<double>(unit[i]), exact[i] / exact.norm(),
                    kRoundings * static_cast<double>(std::numeric_limits<Scalar>::epsilon()));
    }
    Scalar zero[3]{};
    make_unit(zero);
    for (const Scalar value : zero) EXPECT_EQ(value, Scalar(0));
  };
  check(1.0F);
  check(1.0);
}

TEST(CarriedObserver, TracksAVectorThatIsFixedInTheWorldExactlyForAnyRotation) {
  // y' = -w x y with constant w: z stays at S y, and the estimate is the unit vector along it.
  constexpr double kTolerance = 1e-12;
  const auto model = carried_model<double>();
  CarriedObserver observer(model);
  const Vector3d w(2.0, -3.0, 5.0), y0(0.3, -0.5, 0.8);
  for (int k = 0; k < 500; ++k) {
    const double t = 0.02 * k;
    const Vector3d y = Matrix3d(testing::exponential(-cross_matrix(w) * t)) * y0;
    ASSERT_EQ(observer.step(vector<double>(y), vector<double>(w)), StepStatus::kOk);
    for (int c = 0; c < 3; ++c)
      for (int m = 0; m < 3; ++m)
        ASSERT_NEAR(observer.latent()[3 * c + m], model.latent.steady_gain[m][0] * y[c], kTolerance);
    const Vector3d x = eigen(observer.estimate());
    ASSERT_NEAR(std::abs(x.dot(y)) / y.norm(), 1.0, kTolerance);
  }
}

TEST(CarriedObserver, WithoutRotationEqualsTheKklObserverOfEachComponent) {
  const auto model = carried_model<double>();
  CarriedObserver observer(model);
  KklModel<double, 2, 1, 3, 1, LearnedMap<testing::MixedMlp<double, 4, 2>>> plain{};
  testing::set_sampling(plain);
  plain.latent = model.latent;
  for (double& start : plain.latent.initial) start = 0.0;
  KklObserver x(plain), y(plain), z(plain);
  std::mt19937 random(3);
  for (int k = 0; k < 200; ++k) {
    const Vector3d given = random_vector(random, 2.0);
    const double dt = k % 3 == 0 ? 0.02 : testing::uniform<double>(random, 0.001, 0.5);
    ASSERT_LE(observer.step(vector<double>(given), {{0, 0, 0}}, dt), StepStatus::kStale);
    int c = 0;
    for (auto* one : {&x, &y, &z}) {
      ASSERT_EQ(one->step(given[c], dt), observer.status());
      for (int m = 0; m < 3; ++m) ASSERT_EQ(observer.latent()[3 * c + m], one->latent()[m]);
      ++c;
    }
  }
}

template <class Scalar, Arithmetic kArithmetic, bool kReadsOutput, bool kUnitLength>
void expect_equivariance(double tolerance) {
  const auto model = carried_model<Scalar, kReadsOutput, kUnitLength>();
  CarriedObserver<std::remove_const_t<decltype(model)>, kArithmetic> observer(model), turned(model);
  std::mt19937 random(4);
  const Matrix3d q = testing::exponential(cross_matrix(Vector3d(0.4, -1.3, 2.1)));
  for (int k = 0; k < 500; ++k) {
    const Vector3d y = random_vector(random, 3.0), w = random_vector(random, 5.0);
    const auto dt = static_cast<Scalar>(k % 3 == 0 ? 0.02 : testing::uniform<double>(random, 0.001, 0.1));
    ASSERT_LE(observer.step(vector<Scalar>(y), vector<Scalar>(w), dt), StepStatus::kStale);
    ASSERT_EQ(turned.step(vector<Scalar>(q * y), vector<Scalar>(q * w), dt), observer.status());
    const Vector3d difference = q * eigen(observer.estimate()) - eigen(turned.estimate());
    ASSERT_LT(difference.norm(), tolerance) << k;
  }
}

TEST(CarriedObserver, TheEstimateTurnsWithTheAxesOfTheSensor) {
  // The filter adds up the rounding of the turned readings. Normalising a short vector amplifies it.
  constexpr double kFloat = 1e-4, kDouble = 1e-12;
  expect_equivariance<float, Arithmetic::kFast, true, true>(kFloat);
  expect_equivariance<double, Arithmetic::kFast, true, true>(kDouble);
  expect_equivariance<double, Arithmetic::kDeterministic, true, true>(kDouble);
  expect_equivariance<double, Arithmetic::kFast, false, false>(kDouble);
}

/// z after a second with varying w and y, in `steps` steps with linear interpolation between samples.
Eigen::VectorXd turned_for_a_second(int steps) {
  auto model = carried_model<double>();
  model.sample_period_s = 1.0 / steps;
  model.latent.step =
      discretise<1>(Hold::kFirstOrder, model.latent.eigenvalues, model.latent.output_injection, model.sample_period_s);
  using Model = CarriedModel<double, 3, 3, 3, 1, true, true, Hold::kFirstOrder>;
  Model ramped{};
  ramped.sample_period_s = model.sample_period_s;
  ramped.latent = model.latent;
  ramped.outputs = model.outputs;
  CarriedObserver observer(ramped);
  const Vector3d w0(1.0, -2.0, 0.5), w1(-1.5, 1.0, 3.0);  // the axis moves along the ramp between them
  for (int k = 0; k <= steps; ++k) {
    const double t = static_cast<double>(k) / steps;
    EXPECT_EQ(observer.step({{0, 0, 0}}, vector<double>(w0 + t * (w1 - w0))), StepStatus::kOk);
    if (k > 0) continue;
    auto z = observer.latent();
    for (int r = 0; r < 9; ++r) z[r] = 0.3 * r - 1.0;
    EXPECT_TRUE(observer.reset(z, {{0, 0, 0}}, vector<double>(w0)));
  }
  Eigen::VectorXd z(9);
  for (int r = 0; r < 9; ++r) z[r] = observer.latent()[r];
  return z;
}

TEST(CarriedObserver, ConvergesAtOrderFourForAMovingAxis) {
  const Eigen::VectorXd exact = turned_for_a_second(2048);
  const double coarse = (turned_for_a_second(8) - exact).norm(), fine = (turned_for_a_second(16) - exact).norm();
  EXPECT_GT(coarse, 1e-6) << "control: eight steps differ from the solution";
  EXPECT_NEAR(std::log2(coarse / fine), 4.0, 0.2) << coarse << " to " << fine;
}

TEST(CarriedObserver, SolvesItsDifferentialEquation) {
  // z' = D z + F y - w x z by classical Runge-Kutta steps, with y and w constant over the second. Between samples the
  // observer takes y as fixed in the world, but here it is fixed in the body: both agree to (|w| h)^2 / 12 of y, with
  // steps h of 6e-5 s.
  constexpr double kTolerance = 1e-8;
  const auto model = carried_model<double>();
  CarriedObserver observer(model);
  const Vector3d w(1.0, -2.0, 0.5), y(0.4, 0.1, -0.7);
  ASSERT_EQ(observer.step(vector<double>(y), vector<double>(w)), StepStatus::kOk);
  Eigen::Matrix3d z;  // row: component, column: mode
  for (int c = 0; c < 3; ++c)
    for (int m = 0; m < 3; ++m) z(c, m) = observer.latent()[3 * c + m];
  Matrix3d d = Matrix3d::Zero();
  const auto& lambda = model.latent.eigenvalues;
  d << lambda[0], -lambda[1], 0, lambda[1], lambda[0], 0, 0, 0, lambda[2];
  const Eigen::Vector3d f(model.latent.output_injection[0][0], model.latent.output_injection[1][0],
                          model.latent.output_injection[2][0]);
  const auto slope = [&](const Matrix3d& at) -> Matrix3d {
    return at * d.transpose() + y * f.transpose() - cross_matrix(w) * at;
  };
  constexpr int kSteps = 4096;
  constexpr double kStep = 0.25 / kSteps;
  double error = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    const Matrix3d k1 = slope(z), k2 = slope(z + kStep / 2 * k1), k3 = slope(z + kStep / 2 * k2),
                   k4 = slope(z + kStep * k3);
    z += kStep / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    ASSERT_EQ(observer.step(vector<double>(y), vector<double>(w), kStep), StepStatus::kOk);
  }
  for (int c = 0; c < 3; ++c)
    for (int m = 0; m < 3; ++m) error = std::max(error, std::abs(z(c, m) - observer.latent()[3 * c + m]));
  EXPECT_LT(error, kTolerance);
}

TEST(CarriedObserver, AMissingRateIsHeldAndReportedOnlyForItsChannel) {
  const auto model = carried_model<float>();
  CarriedObserver observer(model);
  ASSERT_EQ(observer.step({{0, 0, 1}}, {{0.1F, 0.2F, 0.3F}}), StepStatus::kOk);
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  ASSERT_EQ(observer.step({{0, 0, 1}}, {{0.1F, kNaN, 0.3F}}), StepStatus::kHeld);
  for (int channel = 0; channel < 6; ++channel)
    EXPECT_EQ(observer.status(channel), channel == 4 ? StepStatus::kHeld : StepStatus::kOk) << channel;
  for (const float x : observer.estimate()) EXPECT_TRUE(is_finite(x));
}

TEST(CarriedObserver, EstimatesZeroBeforeItsFirstMeasurement) {
  const auto model = carried_model<float>();
  const CarriedObserver observer(model);
  for (const float x : observer.estimate()) EXPECT_EQ(x, 0.0F);
}

}  // namespace
}  // namespace nlo
