// SPDX-License-Identifier: MIT
// The gated observer: its gates compared with functions of the C library, its step compared with the exponential for
// constant rates and targets, and z stays between -1 and 1.
#include <nlo/gated_observer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/runtime/structures.h"

namespace nlo {
namespace {

using testing::gated_model;

double exact_gate_over(double a, double periods) {
  const double v = 2.0 * a;
  return -std::expm1(-periods * (std::fmax(v, 0.0) + std::log1p(std::exp(-std::fabs(v)))));
}

template <class T>
double worst_gate_over() {
  double worst = 0.0;
  for (double a = -40.0; a <= 40.0; a += 0.037) {
    for (const double periods : {1e-3, 0.1, 0.5, 0.97, 1.0, 1.3, 7.0, 64.0, 1000.0}) {
      const T given = static_cast<T>(a), over = static_cast<T>(periods);
      const double share = static_cast<double>(gate_over(given, over));
      EXPECT_GE(share, 0.0);
      EXPECT_LE(share, 1.0);
      const double exact = exact_gate_over(static_cast<double>(given), static_cast<double>(over));
      worst = std::fmax(worst, std::fabs(share - exact) / std::fmax(1.0, periods));
    }
  }
  return worst;
}

TEST(Gate, IsTheExponentialOfTheSoftplusOverAnyTime) {
  EXPECT_LT(worst_gate_over<float>(), 4.0 * 0x1p-24);
  EXPECT_LT(worst_gate_over<double>(), 4.0 * 0x1p-53);
}

TEST(Gate, EqualsTheSigmoidOfRegularStepsOverOnePeriod) {
  for (double a = -12.0; a <= 12.0; a += 0.01) {
    ASSERT_NEAR(gate_over(a, 1.0), gate_of(tanh_rational(a)), kTanhMaxErrorDouble) << a;
    const auto narrow = static_cast<float>(a);
    ASSERT_NEAR(gate_over(narrow, 1.0F), gate_of(tanh_rational(narrow)), kTanhMaxError) << a;
  }
}

TEST(Gate, AcceptsArgumentsOfAnySize) {
  for (const float a : {1e30F, 3e38F}) {
    EXPECT_EQ(gate_over(a, 1000.0F), 1.0F);
    EXPECT_EQ(gate_over(a, 1e-3F), 1.0F);
    EXPECT_GE(gate_over(-a, 1000.0F), 0.0F);
    EXPECT_LT(gate_over(-a, 1000.0F), 1e-20F);
  }
  EXPECT_EQ(gate_over(1e308, 1e-3), 1.0);
}

TEST(Gate, LogarithmOfOnePlusAgreesWithTheLibrary) {
  for (int i = 0; i <= 1000; ++i) {
    const double t = std::ldexp(1.0, -i % 60) * (1.0 - i / 2000.0);
    ASSERT_NEAR(log_1_plus(t), std::log1p(t), 4.0 * 0x1p-53 * std::log1p(t)) << t;
  }
}

/// All weights are zero, so each rate and target is that of its bias.
template <class Scalar>
auto constant_model() {
  auto model = gated_model<Scalar>(0.0);
  for (auto& w : model.gates.mlp.layer.weights) w = Scalar(0);
  for (auto& w : model.candidate.mlp.layer.weights) w = Scalar(0);
  return model;
}

template <class Scalar>
void expect_exponential(double tolerance) {
  const auto model = constant_model<Scalar>();
  constexpr int kNz = decltype(model)::kNz;
  GatedObserver observer(model);
  std::mt19937 random(3);
  double t_s = 0.02;  // the first measurement is a step of one period
  ASSERT_EQ(observer.step(Scalar(1)), StepStatus::kOk);
  for (int k = 0; k < 200; ++k) {
    if (k % 3 == 0) {
      const auto dt_s = testing::uniform<Scalar>(random, 0.001, 0.3);
      ASSERT_LE(observer.step(Scalar(std::sin(0.1 * k)), dt_s), StepStatus::kStale);
      t_s += static_cast<double>(dt_s);
    } else {
      ASSERT_EQ(observer.step(Scalar(std::sin(0.1 * k))), StepStatus::kOk);
      t_s += 0.02;
    }
    for (int r = 0; r < kNz; ++r) {
      const double v = 2.0 * static_cast<double>(model.gates.mlp.layer.bias[r]);
      const double rate = std::log1p(std::exp(v)) / 0.02;
      const double target = std::tanh(static_cast<double>(model.candidate.mlp.layer.bias[r]));
      const double start = static_cast<double>(model.initial[r]);
      ASSERT_NEAR(observer.latent()[r], target + (start - target) * std::exp(-rate * t_s), tolerance) << k << " " << r;
    }
  }
}

TEST(GatedObserver, EqualsTheExponentialForConstantRatesAndTargets) {
  // Half of the distance is gone after at most 4 periods, so only a few errors of tanh or of rounding remain.
  expect_exponential<double>(1e-14);
  expect_exponential<float>(4e-6);
}

TEST(GatedObserver, StaysBetweenMinusOneAndOneForAnyMeasurement) {
  const auto model = gated_model<float>(30.0);  // saturated gates and targets
  GatedObserver observer(model);
  std::mt19937 random(11);
  float largest = 0.0F;
  for (int k = 0; k < 20000; ++k) {
    const auto y = testing::any_bits<float>(random);
    if (k % 3 == 0) {
      (void)observer.step(y, testing::uniform<float>(random, 1e-6, 3.0));
    } else {
      (void)observer.step(y);
    }
    for (const float z : observer.latent()) largest = std::max(largest, std::fabs(z));
  }
  EXPECT_GT(largest, 0.9F) << "control: it reached its bounds";
  EXPECT_LE(largest, 1.0F + 0x1p-23F) << "at most one rounding unit above 1";
}

TEST(GatedObserver, TheFirstMeasurementIsAStep) {
  const auto model = gated_model<double>();
  GatedObserver observer(model), other(model);
  EXPECT_EQ(observer.step(0.7), StepStatus::kOk);
  double z[decltype(model)::kNz], y[1] = {0.7};
  for (int r = 0; r < decltype(model)::kNz; ++r) z[r] = model.initial[r];
  model.advance(z, y, y, 0.02 * (1.0 - 1e-15));
  for (int r = 0; r < decltype(model)::kNz; ++r) EXPECT_NEAR(observer.latent()[r], z[r], 1e-13);
  EXPECT_NE(observer.latent()[0], other.latent()[0]) << "control";
}

TEST(GatedObserver, DeterministicArithmeticDiffersOnlyByRounding) {
  const auto model = gated_model<float>();
  GatedObserver<std::remove_cv_t<decltype(model)>, Arithmetic::kDeterministic> steady(model);
  GatedObserver fast(model);
  for (int k = 0; k < 500; ++k) {
    const float y = std::sin(0.13F * static_cast<float>(k));
    ASSERT_EQ(steady.step(y), StepStatus::kOk);
    ASSERT_EQ(fast.step(y), StepStatus::kOk);
    for (int r = 0; r < decltype(model)::kNz; ++r) ASSERT_NEAR(steady.latent()[r], fast.latent()[r], 1e-5F);
    ASSERT_NEAR(steady.estimate()[0], fast.estimate()[0], 2e-5F);
  }
}

}  // namespace
}  // namespace nlo
