// SPDX-License-Identifier: MIT
// The estimated standard deviation of an error: 2^v compared with the C library, sigma compared with its formula, and
// its value if the error is unknown. tests/codegen compares all structures with their equations.
#include <nlo/error_head.h>
#include <nlo/kkl_observer.h>

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "tests/runtime/structures.h"

namespace nlo {
namespace {

template <class Scalar, Arithmetic kArithmetic>
double worst_power_of_2() {
  double worst = 0.0;
  for (double v = -100.0; v <= 100.0; v += 0.00137) {
    const auto given = static_cast<Scalar>(v);
    const double exact = std::exp2(static_cast<double>(given));
    worst = std::fmax(worst, std::fabs(static_cast<double>(power_of_2<kArithmetic>(given)) / exact - 1.0));
  }
  return worst;
}

TEST(PowerOfTwo, IsWithinItsStatedErrorOverItsRange) {
  EXPECT_LT((worst_power_of_2<float, Arithmetic::kFast>()), 2e-7);
  EXPECT_LT((worst_power_of_2<float, Arithmetic::kDeterministic>()), 2e-7);
  EXPECT_LT((worst_power_of_2<double, Arithmetic::kFast>()), 5e-16);
  EXPECT_LT((worst_power_of_2<double, Arithmetic::kDeterministic>()), 5e-16);
}

TEST(PowerOfTwo, IsExactForWholeNumbers) {
  for (int n = -100; n <= 100; ++n) {
    EXPECT_EQ(power_of_2(static_cast<float>(n)), std::ldexp(1.0F, n));
    EXPECT_EQ(power_of_2(static_cast<double>(n)), std::ldexp(1.0, n));
  }
}

// One output, three latent states, T* [z; y] to 8 tanh to 2, with an error head.
template <class Scalar>
using Map = LearnedMap<testing::MixedMlp<Scalar, 4, 2>, NoLinearPath, ErrorHead<Scalar, 8, 2>>;
template <class Scalar>
using SureModel = KklModel<Scalar, 2, 1, 3, 1, Map<Scalar>>;

template <class Scalar>
constexpr SureModel<Scalar> sure_model() {
  const auto plain = testing::undriven_model<Scalar>(Hold::kFirstOrder);
  SureModel<Scalar> model{};
  model.sample_period_s = plain.sample_period_s;
  model.stale_after = plain.stale_after;
  model.latent = plain.latent;
  model.outputs = plain.outputs;
  model.domain = plain.domain;
  model.inverse_map.mlp = plain.inverse_map.mlp;
  model.inverse_map.error.layer = pack(testing::mixed_dense<Scalar, 16, 2>(0.7, 5));
  for (int i = 0; i < 2; ++i) {
    model.inverse_map.error.lowest[i] = Scalar(-1);
    model.inverse_map.error.highest[i] = Scalar(0.5 + i);
    model.inverse_map.error.bound_95[i] = Scalar(2 + i);
  }
  return model;
}

constexpr auto kSure = sure_model<float>();
constexpr auto kSureInDouble = sure_model<double>();
constexpr auto kPlain = testing::undriven_model<float>(Hold::kFirstOrder);
static_assert(KnowsError<SureModel<float>>);
static_assert(!KnowsError<testing::UndrivenTestModel<float>>);
static_assert(!KnowsError<testing::PendulumModel<float>>, "z is the estimate");

/// sigma of `model` at z and y, computed in double with the C library.
template <class Scalar>
double exact_sigma(const SureModel<Scalar>& model, const Vector<Scalar, 3>& z, Scalar y, int state) {
  const Scalar in[4] = {z[0], z[1], z[2], y};
  const auto first = testing::mixed_dense<Scalar, 4, 8>(0.8, 3);
  const auto head = testing::mixed_dense<Scalar, 16, 2>(0.7, 5);
  double log2_sigma = static_cast<double>(head.bias[state]);
  for (int o = 0; o < 8; ++o) {
    double sum = static_cast<double>(first.bias[o]);
    for (int i = 0; i < 4; ++i) sum += static_cast<double>(first.weights[o][i]) * static_cast<double>(in[i]);
    const double h = std::tanh(sum);
    log2_sigma +=
        static_cast<double>(head.weights[state][o]) * h + static_cast<double>(head.weights[state][8 + o]) * h * h;
  }
  const auto& error = model.inverse_map.error;
  return std::exp2(std::fmin(std::fmax(log2_sigma, static_cast<double>(error.lowest[state])),
                             static_cast<double>(error.highest[state])));
}

template <class Observer, class Scalar>
double worst_sigma(const SureModel<Scalar>& model, int* held) {
  Observer observer(model);
  double worst = 0.0;
  for (int k = 0; k < 400; ++k) {
    const Scalar y = static_cast<Scalar>(2.0 * std::sin(0.11 * k) + std::cos(0.037 * k));
    (void)observer.step(y);
    const auto estimated = observer.estimate_with_error();
    for (int i = 0; i < 2; ++i) {
      const double exact = exact_sigma(model, observer.latent(), y, i);
      worst = std::fmax(worst, std::fabs(static_cast<double>(estimated.sigma[i]) / exact - 1.0));
      if (exact == std::exp2(-1.0) || exact == std::exp2(0.5 + i)) ++*held;
      EXPECT_EQ(estimated.bound_95[i], estimated.sigma[i] * static_cast<Scalar>(2 + i));
    }
  }
  return worst;
}

// tanh within 5e-7 and float sums of 17 terms of order 1, times log 2; in double the same with its own rounding.
constexpr double kFloatSigma = 5e-6, kDoubleSigma = 2e-14;

TEST(ErrorHead, EqualsItsFormulaInEveryArithmetic) {
  int held = 0;
  EXPECT_LT(worst_sigma<KklObserver<SureModel<float>>>(kSure, &held), kFloatSigma);
  EXPECT_LT((worst_sigma<KklObserver<SureModel<float>, Arithmetic::kDeterministic>>(kSure, &held)), kFloatSigma);
  EXPECT_LT(worst_sigma<KklObserver<SureModel<double>>>(kSureInDouble, &held), kDoubleSigma);
  EXPECT_GT(held, 0) << "control: no sigma reached a limit of its range, so the limits are untested";
}

/// Compares a head of this width with its formula, with NaN after the end of h.
template <int kWidth>
void expect_nothing_is_read_after_the_squares() {
  const auto weights = testing::mixed_dense<float, 2 * kWidth, 1>(0.7, 5);
  ErrorHead<float, kWidth, 1> head{};
  head.layer = pack(weights);
  alignas(64) float h[64];
  for (float& value : h) value = std::numeric_limits<float>::quiet_NaN();
  double want = static_cast<double>(weights.bias[0]);
  for (int i = 0; i < kWidth; ++i) {
    h[i] = 0.25F * static_cast<float>(i % 4 + 1);
    want += static_cast<double>(weights.weights[0][i] * h[i]) +
            static_cast<double>(weights.weights[0][kWidth + i] * h[i] * h[i]);
  }
  float log2_sigma = 0.0F;
  head.evaluate(h, &log2_sigma);
  EXPECT_TRUE(std::isnan(h[kernels::padded(2 * kWidth)])) << "nothing is written after the zeros";
  EXPECT_NEAR(log2_sigma, want, 2e-6) << kWidth << ": 18 terms of order 1 in float";
}

TEST(ErrorHead, ReadsNothingAfterItsSquaresForOddWidths) {
  expect_nothing_is_read_after_the_squares<3>();
  expect_nothing_is_read_after_the_squares<8>();
  expect_nothing_is_read_after_the_squares<9>();  // wide enough for kernels to read whole vectors
}

template <Arithmetic kArithmetic>
void expect_the_estimate_without_a_head() {
  KklObserver<SureModel<float>, kArithmetic> sure(kSure);
  KklObserver<testing::UndrivenTestModel<float>, kArithmetic> plain(kPlain);
  for (int k = 0; k < 50; ++k) {
    const float y = static_cast<float>(std::sin(0.2 * k));
    ASSERT_EQ(sure.step(y), plain.step(y));
    const auto estimated = sure.estimate_with_error();
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(std::bit_cast<std::uint32_t>(estimated.x_hat[i]), std::bit_cast<std::uint32_t>(plain.estimate()[i]));
      EXPECT_EQ(std::bit_cast<std::uint32_t>(sure.estimate()[i]), std::bit_cast<std::uint32_t>(plain.estimate()[i]));
    }
  }
}

TEST(ErrorHead, DoesNotChangeTheEstimate) {
  expect_the_estimate_without_a_head<Arithmetic::kFast>();
  expect_the_estimate_without_a_head<Arithmetic::kDeterministic>();
}

TEST(ErrorHead, IsUnknownOutsideOfTheDomain) {
  KklObserver<SureModel<float>> observer(kSure);
  for (const float far : {5.5F, 1e6F, 1e30F}) {
    ASSERT_TRUE(observer.reset({{far, 0.0F, 0.0F}}, {{0.0F}}));
    ASSERT_FALSE(observer.in_domain());
    const auto estimated = observer.estimate_with_error();
    for (int i = 0; i < 2; ++i) {
      EXPECT_EQ(estimated.sigma[i], kUnknownSigma);
      EXPECT_GE(estimated.bound_95[i], kUnknownSigma) << "it exceeds any limit of a user";
      EXPECT_TRUE(std::isfinite(estimated.bound_95[i]));
    }
  }
}

TEST(ErrorHead, IsUnknownWhileAReadingIsStale) {
  KklObserver<SureModel<float>> observer(kSure);
  (void)observer.step(1.0F);
  int held = 0;
  while (observer.step_missed() == StepStatus::kHeld) {
    ++held;
    EXPECT_EQ(observer.estimate_with_error().sigma[0] < kUnknownSigma, observer.in_domain());
  }
  ASSERT_EQ(observer.status(), StepStatus::kStale);
  EXPECT_GT(held, 0) << "control: a held reading does not make the error unknown";
  EXPECT_EQ(observer.estimate_with_error().sigma[0], kUnknownSigma);
  (void)observer.step(1.0F);
  EXPECT_EQ(observer.estimate_with_error().sigma[0] < kUnknownSigma, observer.in_domain());
}

TEST(ErrorHead, StaysFiniteForAnyMeasurement) {
  KklObserver<SureModel<float>> observer(kSure);
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -3e38F, 0.0F};
  const StepStatus expected[] = {StepStatus::kHeld, StepStatus::kHeld, StepStatus::kOutOfRange, StepStatus::kOk};
  (void)observer.step(1.0F);
  for (int round = 0; round < 3; ++round) {
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(observer.step(bad[k]), expected[k]);
      for (const float sigma : observer.estimate_with_error().sigma) {
        EXPECT_GE(sigma, std::exp2(-1.0F));
        EXPECT_LE(sigma, observer.in_domain() ? std::exp2(1.5F) : kUnknownSigma);
      }
    }
  }
}

TEST(ErrorHead, TreatsNanAsTheLargestError) {
  const auto& head = kSure.inverse_map.error;
  for (const float v : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e30F}) {
    EXPECT_FLOAT_EQ(head.deviation(0, v, true), std::exp2(0.5F));
    EXPECT_FLOAT_EQ(head.deviation<Arithmetic::kDeterministic>(0, v, true), std::exp2(0.5F));
  }
  EXPECT_EQ(head.deviation(0, -1e30F, true), 0.5F);
}

}  // namespace
}  // namespace nlo
