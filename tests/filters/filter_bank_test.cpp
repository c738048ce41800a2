// SPDX-License-Identifier: MIT
#include "trainer/filters/filter_bank.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/filters/lanes.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;

constexpr double kStep = 0.02;

/// dx/dt = -0.3 x, y = (x - 1)^2: two states explain each output, and only the way y goes on tells which.
LanePlant ambiguous() {
  LanePlant plant = test::decay(0.3);
  plant.h = [](const MatrixXd& x, const MatrixXd&) { return MatrixXd((x.array() - 1.0).square()); };
  return plant;
}

/// Of a run from x0, without noise; x in the first row, y in the second.
MatrixXd run_from(double x0) {
  MatrixXd run(2, 101);
  for (Eigen::Index k = 0; k < run.cols(); ++k) {
    run(0, k) = x0 * std::pow(test::rk4_decay(0.3, kStep), static_cast<double>(k));
    run(1, k) = std::pow(run(0, k) - 1.0, 2);
  }
  return run;
}

FilterKnowledge wide_start() {
  FilterKnowledge known = test::scalar_knowledge(1.5, 1e-3, 0.05);
  known.initial_state[0] = 0.9;
  return known;
}

double error_at_the_end(LaneFilter& filter, const MatrixXd& run) {
  const MatrixXd x = test::estimates_of(filter, test::runs_of(run.row(1), kStep));
  return std::abs(x(0, x.cols() - 1) - run(0, x.cols() - 1));
}

TEST(FilterBank, FindsTheStateThatOneFilterMisses) {
  const MatrixXd starts = Eigen::RowVectorXd::LinSpaced(8, -1.5, 3.5);
  double worst_of_one = 0.0;
  for (const double x0 : {-0.5, 2.5}) {
    FilterBank bank(ambiguous(), wide_start(), starts, {{}}, 1);
    EXPECT_LT(error_at_the_end(bank, run_from(x0)), 0.02) << x0;
    EXPECT_NEAR(bank.weights().col(0).sum(), 1.0, 1e-12);
    SigmaPointFilter one(ambiguous(), PointSet::kExtended, wide_start(), {{}}, 1);
    worst_of_one = std::max(worst_of_one, error_at_the_end(one, run_from(x0)));
  }
  EXPECT_GT(worst_of_one, 0.3) << "control: the other state explains the outputs as well";
}

TEST(FilterBank, OfOneMemberIsTheFilterItself) {
  const MatrixXd run = run_from(0.7);
  FilterBank bank(ambiguous(), wide_start(), MatrixXd::Constant(1, 1, 0.9), {{}}, 1);
  SigmaPointFilter one(ambiguous(), PointSet::kExtended, wide_start(), {{}}, 1);
  const LaneRuns runs = test::runs_of(run.row(1), kStep);
  EXPECT_EQ(test::estimates_of(bank, runs), test::estimates_of(one, runs));
}

TEST(FilterBank, TakesEachLaneByItself) {
  const LaneRuns one = test::runs_of(run_from(2.5).row(1), kStep), three = repeated(one, 3);
  const MatrixXd starts = Eigen::RowVectorXd::LinSpaced(4, -1.5, 3.5);
  FilterTuning trusting;
  trusting.output = 0.1;
  FilterBank all(ambiguous(), wide_start(), starts, {{}, trusting, {}}, 3);
  FilterBank middle(ambiguous(), wide_start(), starts, {trusting}, 1);
  for (Eigen::Index k = 0; k < one.samples(); ++k) {
    const MatrixXd x = all.step(three, k);
    EXPECT_NEAR(x(0, 1), middle.step(one, k)(0, 0), 1e-9) << "vector instructions: the same sums but for fused ones";
    EXPECT_NEAR(x(0, 0), x(0, 2), 1e-9);
  }
}

}  // namespace
}  // namespace nlo::trainer
