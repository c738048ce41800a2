// SPDX-License-Identifier: MIT
// Compares bounds of rounding errors with the same sums in long double.
#include "trainer/prove/rounding.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "codegen/base/linear_algebra.h"
#include "tests/prove/random_inverse_map.h"

namespace nlo::trainer {
namespace {

using Exact = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;

// Rounds up to double.
double above(long double value) {
  return std::nextafter(static_cast<double>(value), std::numeric_limits<double>::infinity());
}

TEST(Rounding, GammaIsSlightlyAboveItsExactValue) {
  for (const long double n : {1.0L, 2.0L, 3.0L, 17.0L, 1000.0L, 1e9L}) {
    const long double u = 0x1p-53L, exact = n * u / (1.0L - n * u);
    EXPECT_GE(static_cast<long double>(gamma(n)), exact);
    EXPECT_LE(static_cast<long double>(gamma(n)), exact * (1.0L + 10.0L * u));
  }
}

TEST(Rounding, UpwardIsAboveTheExactSum) {
  std::mt19937 engine(3);
  std::uniform_real_distribution<double> draw(0.0, 1.0);
  int below = 0;
  for (int run = 0; run < 2000; ++run) {
    double sum = 0.0;
    long double exact = 0.0L;
    for (int i = 0; i < 20; ++i) {
      const double term = draw(engine);
      sum += term;
      exact += static_cast<long double>(term);
    }
    below += static_cast<long double>(sum) < exact;
    ASSERT_GE(static_cast<long double>(upward(sum, 20.0)), exact);
  }
  EXPECT_GT(below, 500) << "control: without it, sums are below the exact value";
}

TEST(Rounding, ProductErrorBoundsTheErrorOfAProduct) {
  std::mt19937 engine(5);
  double largest = 0.0;
  for (int run = 0; run < 200; ++run) {
    const Eigen::MatrixXd a = random(engine, 7, 33), b = random(engine, 33, 5), bound = product_error(a, b);
    const Eigen::MatrixXd product = a * b;
    const Exact off = product.cast<long double>() - a.cast<long double>() * b.cast<long double>();
    for (Eigen::Index i = 0; i < off.size(); ++i) {
      ASSERT_LE(above(std::abs(off(i))), bound(i));
      largest = std::max(largest, above(std::abs(off(i))) / bound(i));
    }
  }
  EXPECT_GT(largest, 0.01) << "control: a bound a hundred times smaller would be broken";
}

TEST(Rounding, NormIsSlightlyAboveTheLargestSingularValue) {
  constexpr double kWide = 1.0 + 1e-12;
  std::mt19937 engine(7);
  for (const Eigen::Index rows : {1, 2, 3, 8, 32})
    for (const Eigen::Index columns : {1, 2, 5, 40}) {
      const Eigen::MatrixXd m = random(engine, rows, columns);
      const double bound = norm_above(m), value = codegen::singular_values(m)(0);
      EXPECT_GE(bound, value * (1.0 - 4.0 * kUnit * static_cast<double>(m.size())));
      EXPECT_LE(bound, value * kWide);
      EXPECT_GE(rough_norm_above(m), value * (1.0 - 1e-12));
      EXPECT_LE(rough_norm_above(m), value * 1.01);
      EXPECT_EQ(norm_above(m, 2.0 * value), 2.0 * value);
      EXPECT_GE(norm_above(m, 0.99 * value), value * (1.0 - 1e-12)) << "a guess that is too small has no effect";
      // In long double: |m v| for the best v in double, a lower bound of the norm.
      const auto system = codegen::eigensystem(m.transpose() * m);
      Eigen::Index best = 0;
      system.values.real().maxCoeff(&best);
      const Exact v = system.vectors.col(best).real().cast<long double>();
      const long double reached = (m.cast<long double>() * v).norm() / v.norm();
      EXPECT_GE(static_cast<long double>(bound), reached) << rows << " x " << columns;
      EXPECT_LT(0.5L * static_cast<long double>(bound), reached) << "control";
    }
}

TEST(Rounding, NormIsExactForEqualSingularValuesForZeroAndForEmptyMatrices) {
  EXPECT_GE(norm_above(Eigen::MatrixXd::Identity(9, 9)), 1.0);
  EXPECT_LE(norm_above(Eigen::MatrixXd::Identity(9, 9)), 1.0 + 1e-12);
  EXPECT_LE(norm_above(Eigen::MatrixXd::Zero(4, 4)), 1e-150);
  EXPECT_EQ(norm_above(Eigen::MatrixXd()), 0.0);
  EXPECT_EQ(norm_above(Eigen::MatrixXd::Constant(3, 3, std::numeric_limits<double>::quiet_NaN())),
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace nlo::trainer
