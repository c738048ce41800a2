// SPDX-License-Identifier: MIT
#include "trainer/filters/moving_horizon.h"

#include <gtest/gtest.h>

#include "tests/filters/lanes.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;

constexpr double kHorizonPeriod = 0.02;

TEST(MovingHorizon, OfALinearPlantWithoutNoiseOfItsOwnIsTheKalmanFilter) {
  // One Gauss-Newton step solves a linear problem, and least squares over the window with the filter's prediction
  // before it is least squares over all: the Kalman filter's estimate.
  const MatrixXd y = MatrixXd::Constant(1, 120, 1.0) + 0.3 * test::normals(1, 120, 5);
  const FilterKnowledge known = test::scalar_knowledge(1.0, 0.0, 0.3);
  const LaneRuns runs = test::runs_of(y, kHorizonPeriod);
  MovingHorizonFilter horizon(test::decay(0.5), known, {{}}, 1, 10);
  SigmaPointFilter kalman(test::decay(0.5), PointSet::kExtended, known, {{}}, 1);
  const MatrixXd own = test::estimates_of(horizon, runs), other = test::estimates_of(kalman, runs);
  EXPECT_LE((own - other).cwiseAbs().maxCoeff(), 1e-9);  // differences over 1e-4 of a deviation, in double
}

TEST(MovingHorizon, LetsAnOutlierPullNoMoreThanItsGate) {
  MatrixXd y = MatrixXd::Constant(1, 60, 0.0) + 0.1 * test::normals(1, 60, 6);
  const auto shift = [&](double gate, double outlier) {
    FilterTuning tuning;
    tuning.gate = gate;
    const auto last = [&](double v) {
      MatrixXd measured = y;
      measured(0, 55) += v;
      MovingHorizonFilter filter(test::decay(0.5), test::scalar_knowledge(1.0, 1e-2, 0.1), {tuning}, 1, 20);
      return test::estimates_of(filter, test::runs_of(measured, kHorizonPeriod))(0, 59);
    };
    return std::abs(last(outlier) - last(0.0));
  };
  const double open = std::numeric_limits<double>::infinity();
  // Iterated weights: what is left is the gate's share, however far out the sample lies.
  EXPECT_LT(shift(2.0, 100.0), 2.0 * shift(2.0, 10.0) + 1e-3);
  EXPECT_GT(shift(open, 100.0), 5.0 * shift(open, 10.0)) << "control: without a gate it pulls in proportion";
}

}  // namespace
}  // namespace nlo::trainer
