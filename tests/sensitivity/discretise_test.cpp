// SPDX-License-Identifier: MIT
// Coefficients of a sample period, their slopes by dual numbers, and the parameters that eigenvalues have in training.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/sensitivity/latent_problem.h"
#include "trainer/sensitivity/dual.h"

namespace nlo::trainer {
namespace {

TEST(Discretise, DualSlopesMeetCentralDifferencesAlongBothAxes) {
  // Analytic in lambda: a step along i has i times the same slope.
  constexpr double kTolerance = 1e-8;  // central differences in double at 1e-5: 1e-10 truncated, 1e-11 rounded
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

TEST(Discretise, DualValuesAreThePlainValues) {
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
