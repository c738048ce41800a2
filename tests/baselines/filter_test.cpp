// SPDX-License-Identifier: MIT
#include "trainer/baselines/filter.h"

#include <gtest/gtest.h>

#include "trainer/baselines/ekf.h"
#include "trainer/baselines/ukf.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(Filters, BeginAnewAfterAnOutlierThatTheirLinearisationCannotSurvive) {
  // dx/dt = -x^3 is as stable as can be, and RK4 leaves the numbers from x = 1e7 in steps of 0.1 s.
  const FilterPlant plant{[](const MatrixXd& x) { return MatrixXd(-x.array().cube()); },
                          [](const MatrixXd& x) { return x; }};
  constexpr double kOutlier = 1e7;
  ASSERT_FALSE((advance(plant, MatrixXd::Constant(1, 1, kOutlier), 0.1, {}, {}).array().abs() <= 1e9).all())
      << "control: without a new beginning nothing after the outlier would be a number";

  // Process noise of 1: the filters believe the measurement, gain 0.99.
  const FilterConfig config{VectorXd::Zero(1), MatrixXd::Identity(1, 1), 1.0, VectorXd::Constant(1, 0.01)};
  constexpr Index kSamples = 40, kAt = 20;
  MatrixXd y = MatrixXd::Constant(1, kSamples, 0.2);
  y(0, kAt) = kOutlier;
  const VectorXd time_s = VectorXd::LinSpaced(kSamples, 0.0, 3.9);
  const auto make = [&] { return plant; };
  for (const EstimatorFactory& factory : {ekf_estimator(make, config), ukf_estimator(make, config)}) {
    const MatrixXd estimate = factory()(y, {}, time_s);
    ASSERT_TRUE(estimate.allFinite());
    EXPECT_NEAR(estimate(0, kAt - 1), 0.2, 0.02);
    EXPECT_NEAR(estimate(0, kSamples - 1), 0.2, 0.02);  // of a steady gain near 1
  }
}

}  // namespace
}  // namespace nlo::trainer
