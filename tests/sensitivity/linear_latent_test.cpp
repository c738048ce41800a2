// SPDX-License-Identifier: MIT
// Coefficients of a sample period, their derivatives by dual numbers, and the parameters of eigenvalues in training.
#include "trainer/gradients/sensitivity/linear_latent.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "nlo/kkl_observer.h"
#include "tests/sensitivity/latent_problem.h"
#include "trainer/gradients/sensitivity/dual.h"

namespace nlo::trainer {
namespace {

// Tolerance of z relative to the largest |z|: float32 rounding (6e-8) accumulates over 1 / |1 - a| samples, about 50
// for the slowest mode here.
constexpr double kFilterTolerance = 3e-6;
// Tolerance of a gradient relative to the sum of the absolute values of its terms. The gradient is a float32 sum over 8
// x 120 samples whose errors mostly cancel: 1e-7 measured.
constexpr double kGradientTolerance = 6e-7;

TEST(LinearLatent, FilterAgreesWithTheComplexRecurrenceInEveryVariant) {
  for_all_problems([](Problem& problem) {
    problem.run_filter();
    for (int lane = 0; lane < kGroup; ++lane) {
      const std::vector<Cd> z = problem.plain(problem.lambda(), lane);
      double largest = 0.0;
      for (const Cd& at : z) largest = std::max(largest, std::abs(at));
      for (int t = 0; t < kLength; ++t) {
        for (int row = 0; row < problem.shape.rows; ++row) {
          const float actual = problem.group.latent[problem.group.at(row, t) + static_cast<std::size_t>(lane)];
          const Cd expected = z[static_cast<std::size_t>(t)];
          ASSERT_NEAR(static_cast<double>(actual), row == 0 ? expected.real() : expected.imag(),
                      kFilterTolerance * largest)
              << "lane " << lane << " sample " << t << " row " << row;
        }
      }
    }
  });
}

TEST(LinearLatent, AdjointAgreesWithCentralDifferencesInEveryVariant) {
  constexpr double kStep = 1e-5;  // truncation 1e-10, rounding 1e-16 * 1e3 / 1e-5 = 1e-8: far below the tolerance
  for_all_problems([](Problem& problem) {
    problem.run_adjoint();
    double size = 0.0;
    problem.loss(problem.p(), problem.q(), &size);
    const double by_p =
        (problem.loss(problem.p() + kStep, problem.q()) - problem.loss(problem.p() - kStep, problem.q())) /
        (2.0 * kStep);
    ASSERT_NEAR(problem.group.gradient[0], by_p, kGradientTolerance * size);
    ASSERT_GT(std::abs(by_p), 50.0 * kGradientTolerance * size) << "the tolerance would pass a gradient of zero";
    if (!problem.shape.modes[0].pair) return;
    const double by_q =
        (problem.loss(problem.p(), problem.q() + kStep) - problem.loss(problem.p(), problem.q() - kStep)) /
        (2.0 * kStep);
    ASSERT_NEAR(problem.group.gradient[1], by_q, kGradientTolerance * size);
    ASSERT_GT(std::abs(by_q), 50.0 * kGradientTolerance * size) << "the tolerance would pass a gradient of zero";
  });
}

TEST(LinearLatent, AdjointOfTheInitialStateAgreesWithItsClosedForm) {
  // z_0 = s y_0 depends on lambda only through s = -f / lambda: closed form, nothing to integrate.
  for (const bool pair : {false, true}) {
    Problem problem(Hold::kFirstOrder, Injection::kOnes, pair, false, true);
    std::fill(problem.group.cotangent.begin() + kGroup, problem.group.cotangent.begin() + problem.group.length * kGroup,
              0.0F);
    if (pair)
      std::fill(problem.group.cotangent.begin() + problem.group.length * kGroup, problem.group.cotangent.end(), 0.0F);
    problem.run_adjoint();
    const Cd lambda = problem.lambda();
    const Cd f = plain_injection(Injection::kOnes, pair, lambda);
    double expected = 0.0;
    for (std::size_t lane = 0; lane < kGroup; ++lane) {
      const Cd slope = f / (lambda * lambda) * static_cast<double>(problem.group.readings[lane]) * lambda.real();
      expected += static_cast<double>(problem.group.cotangent[lane]) * slope.real();
    }
    EXPECT_NEAR(problem.group.gradient[0], expected, 1e-5 * std::abs(expected)) << (pair ? "pair" : "real");
  }
}

TEST(LinearLatent, GradientIsTheSumOverTheLanes) {
  Problem all(Hold::kFirstOrder, Injection::kOnes, true, true, true);
  double sum[2] = {};
  for (std::size_t lane = 0; lane < kGroup; ++lane) {
    Problem one = all;
    for (std::size_t i = 0; i < one.group.cotangent.size(); ++i) {
      if (i % kGroup != lane) one.group.cotangent[i] = 0.0F;
    }
    one.run_adjoint();
    for (std::size_t r = 0; r < 2; ++r) sum[r] += one.group.gradient[r];
  }
  all.run_adjoint();
  double size = 0.0;
  all.loss(all.p(), all.q(), &size);
  for (std::size_t r = 0; r < 2; ++r) EXPECT_NEAR(all.group.gradient[r], sum[r], kGradientTolerance * size);
}

SegmentGroup mixed_group(const LatentShape& shape) {
  SegmentGroup group;
  group.length = kLength;
  group.lanes = kGroup;
  group.readings.resize(group.at(2, 0));
  group.latent.resize(group.at(shape.rows, 0));
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-1.0F, 2.0F);
  for (float& y : group.readings) y = uniform(random);
  return group;
}

TEST(LinearLatent, FilterAgreesWithTheObserverOfTheRuntime) {
  // The runtime has the same coefficients in float32 and the same order of operations; only fused multiply-adds differ.
  using Map = LearnedMap<Mlp<Activation::kTanh, PackedDense<float, 7, 1>>>;
  using Flown = KklModel<float, 1, 2, 7, 2, Map>;
  const LatentShape shape = mixed_shape();
  Coefficients coefficients;
  coefficients.compute(shape, kMixed, {kPeriod});
  SegmentGroup group = mixed_group(shape);
  filter(shape, coefficients, group);

  Flown model{};
  model.sample_period_s = static_cast<float>(kPeriod);
  model.stale_after = 10;
  double f[7][2] = {};
  double eigenvalues[7];
  for (int r = 0; r < 7; ++r) eigenvalues[r] = kMixed[r];
  for (const Mode& mode : shape.modes) {
    if (mode.reading < 0) {
      model.latent.initial[mode.row] = 1.0F;
      continue;
    }
    const Cd lambda{kMixed[mode.row], mode.pair ? kMixed[mode.row + 1] : 0.0};
    const Cd in = plain_injection(shape.injection, mode.pair, lambda);
    const Cd steady = -in / lambda;
    f[mode.row][mode.reading] = in.real();
    model.latent.steady_gain[mode.row][mode.reading] = static_cast<float>(steady.real());
    if (!mode.pair) continue;
    f[mode.row + 1][mode.reading] = in.imag();
    model.latent.steady_gain[mode.row + 1][mode.reading] = static_cast<float>(steady.imag());
  }
  const auto step = discretise<2>(Hold::kFirstOrder, eigenvalues, f, kPeriod);
  for (int r = 0; r < 7; ++r) {
    model.latent.step.a_minus_1[r] = static_cast<float>(step.a_minus_1[r]);
    for (int j = 0; j < 2; ++j) {
      model.latent.step.b0[r][j] = static_cast<float>(step.b0[r][j]);
      model.latent.step.b1[r][j] = static_cast<float>(step.b1[r][j]);
    }
  }
  model.latent.starts_steady = true;
  for (int j = 0; j < 2; ++j) {
    model.outputs.min[j] = -10.0F;
    model.outputs.max[j] = 10.0F;
  }
  for (std::size_t lane = 0; lane < kGroup; ++lane) {
    KklObserver<Flown> observer(model);
    for (int t = 0; t < kLength; ++t) {
      ASSERT_EQ(observer.step({{group.readings[group.at(0, t) + lane], group.readings[group.at(1, t) + lane]}}),
                StepStatus::kOk);
      for (int r = 0; r < 7; ++r) {
        ASSERT_NEAR(observer.latent()[r], group.latent[group.at(r, t) + lane], static_cast<float>(kFilterTolerance))
            << "row " << r << " sample " << t;
      }
    }
  }
}

TEST(LinearLatent, AClockDecaysFromOneForAnyOutputs) {
  LatentShape shape = mixed_shape();
  for (const bool jittered : {false, true}) {
    const std::vector<double> steps = jittered ? std::vector<double>{0.01, 0.035} : std::vector<double>{kPeriod};
    Coefficients coefficients;
    coefficients.compute(shape, kMixed, steps);
    SegmentGroup group = mixed_group(shape);
    if (jittered) {
      for (std::size_t i = 0; i < group.at(1, 0); ++i) group.step_of.push_back(i % 3 == 0 ? 1 : 0);
    }
    filter(shape, coefficients, group);
    for (std::size_t lane = 0; lane < kGroup; ++lane) {
      double time = 0.0;
      for (int t = 0; t < kLength; ++t) {
        ASSERT_NEAR(static_cast<double>(group.latent[group.at(6, t) + lane]), std::exp(-0.25 * time), kFilterTolerance);
        time += steps[jittered ? static_cast<std::size_t>(group.step_of[group.at(0, t) + lane]) : 0];
      }
    }
  }
}

TEST(LinearLatent, AClockHasNoGradient) {
  const LatentShape shape = mixed_shape();
  Coefficients coefficients;
  coefficients.compute(shape, kMixed, {kPeriod});
  SegmentGroup group = mixed_group(shape);
  filter(shape, coefficients, group);
  group.cotangent.assign(group.latent.size(), 0.0F);
  for (std::size_t i = group.at(6, 0); i < group.cotangent.size(); ++i) group.cotangent[i] = 1.0F;
  adjoint_filter(shape, coefficients, kMixed, group);
  ASSERT_EQ(group.gradient.size(), 6U);
  for (const double g : group.gradient) EXPECT_EQ(g, 0.0);
}

TEST(Discretise, DualDerivativesAgreeWithCentralDifferencesAlongBothAxes) {
  // The function is analytic in lambda, so a step along the imaginary axis has i times the same derivative.
  constexpr double kTolerance = 1e-8;  // central differences in double at 1e-5: truncation 1e-10, rounding 1e-11
  constexpr double kStep = 1e-5;
  const Cd lambdas[] = {{-0.01, 0.0}, {-1.0, 0.0}, {-40.0, 0.0}, {-0.3, 5.0}, {-2.0, 0.001}, {-20.0, 60.0}};
  for (const Hold hold : kHolds) {
    for (const Cd lambda : lambdas) {
      for (const double h : {0.004, 0.02, 0.04}) {
        SCOPED_TRACE(name_of(hold));
        const auto dual = discretise(hold, Complex<Dual>{Dual(lambda.real(), 1.0), Dual(lambda.imag())}, Dual(h));
        for (const Cd direction : {Cd{1.0, 0.0}, Cd{0.0, 1.0}}) {
          const auto at = [&](double s) {
            const Cd moved = lambda + s * direction;
            return discretise(hold, Complex<double>{moved.real(), moved.imag()}, h);
          };
          const auto check = [&](const Complex<Dual>& slope, Complex<double> above, Complex<double> below) {
            const Cd expected = direction * Cd{slope.re.slope, slope.im.slope};
            EXPECT_NEAR((above.re - below.re) / (2.0 * kStep), expected.real(), kTolerance) << lambda << " h " << h;
            EXPECT_NEAR((above.im - below.im) / (2.0 * kStep), expected.imag(), kTolerance) << lambda << " h " << h;
          };
          check(dual.a_minus_1, at(kStep).a_minus_1, at(-kStep).a_minus_1);
          check(dual.b0, at(kStep).b0, at(-kStep).b0);
          check(dual.b1, at(kStep).b1, at(-kStep).b1);
        }
      }
    }
  }
}

TEST(Discretise, DualValuesEqualThePlainValues) {
  for (const Hold hold : kHolds) {
    const auto dual = discretise(hold, Complex<Dual>{Dual(-3.0, 1.0), Dual(7.0)}, Dual(kPeriod));
    const auto plain = discretise(hold, Complex<double>{-3.0, 7.0}, kPeriod);
    EXPECT_DOUBLE_EQ(dual.a_minus_1.re.value, plain.a_minus_1.re);
    EXPECT_DOUBLE_EQ(dual.b0.im.value, plain.b0.im);
    EXPECT_DOUBLE_EQ(dual.b1.re.value, plain.b1.re);
  }
}

TEST(EigenvalueParameters, ReadBackToTheSameEigenvaluesAndStayStable) {
  const LatentShape shape = mixed_shape();
  const std::vector<float> parameters = parameters_from_eigenvalues(shape, kMixed);
  ASSERT_EQ(parameters.size(), 6U);
  double back[7] = {0, 0, 0, 0, 0, 0, kMixed[6]};
  eigenvalues_from_parameters(shape, parameters.data(), back);
  for (int r = 0; r < 7; ++r) EXPECT_NEAR(back[r], kMixed[r], 2e-7 * std::abs(kMixed[r])) << "row " << r;
  for (const float p : {-20.0F, 0.0F, 20.0F}) {
    const std::vector<float> same(6, p);
    eigenvalues_from_parameters(shape, same.data(), back);
    for (const int row : {0, 2, 4, 5}) EXPECT_LT(back[row], 0.0);
  }
}

}  // namespace
}  // namespace nlo::trainer
