// SPDX-License-Identifier: MIT
#include "trainer/filters/sigma_point_filter.h"

#include <gtest/gtest.h>

#include "tests/filters/lanes.h"
#include "trainer/baselines/ekf.h"
#include "trainer/baselines/ukf.h"
#include "trainer/config/experiment.h"
#include "trainer/filters/high_gain.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kPeriod = 0.02;

LanePlant van_der_pol() {
  PlantConfig config;
  config.model = "van_der_pol";
  return lane_plant(make_plant(config));
}

/// Truth and noisy output of one run of 10 s.
struct VanDerPolRun {
  VanDerPolRun() {
    PlantConfig config;
    config.model = "van_der_pol";
    SimulationConfig simulation;
    simulation.horizon_s = 10.0;
    const Dataset set = simulate_from(*make_plant(config), simulation, Vector2d(0.7, -0.4));
    truth = set.trajectories[0].states;
    time_s = set.trajectories[0].time_s;
    outputs = truth.topRows(1) + 0.5 * test::normals(1, truth.cols(), 3);
  }
  MatrixXd truth, outputs;
  VectorXd time_s;
};

FilterKnowledge box_knowledge() {
  return {Vector2d::Zero(), Vector2d::Constant(std::sqrt(1.0 / 3.0)), Vector2d::Constant(1e-3),
          VectorXd::Constant(1, 0.5)};
}

// The two filters form covariances, these do not: they part by rounding and by the width of differences.
constexpr double kSameFilter = 1e-6;

TEST(SigmaPointFilter, IsTheFiltersOfTheBaselinesInAnotherForm) {
  const VanDerPolRun run;
  const LanePlant plant = van_der_pol();
  const FilterPlant known{[&](const MatrixXd& x) { return plant.f(x, MatrixXd()); }, plant.h};
  const FilterConfig config = ekf_config(Vector2d(-1.0, -1.0), Vector2d(1.0, 1.0), {NoiseKind::kGaussian, 0.5});
  const LaneRuns lanes = test::runs_of(run.outputs, kPeriod);
  SigmaPointFilter extended(plant, PointSet::kExtended, box_knowledge(), {{}}, 1);
  SigmaPointFilter unscented(plant, PointSet::kUnscented, box_knowledge(), {{}}, 1);
  const MatrixXd ekf = test::estimates_of(extended, lanes), ukf = test::estimates_of(unscented, lanes);
  const MatrixXd ekf_covariance = ekf_estimator([&] { return known; }, config)()(run.outputs, {}, run.time_s);
  const MatrixXd ukf_covariance = ukf_estimator([&] { return known; }, config)()(run.outputs, {}, run.time_s);
  EXPECT_LE((ekf - ekf_covariance).cwiseAbs().maxCoeff(), kSameFilter);
  EXPECT_LE((ukf - ukf_covariance).cwiseAbs().maxCoeff(), kSameFilter);
  EXPECT_GT((ekf - ukf).cwiseAbs().maxCoeff(), 100.0 * kSameFilter) << "control: the two filters differ";
}

TEST(SigmaPointFilter, SettlesAtTheRiccatiEquationsCovariance) {
  // dx/dt = -x / 2: p- = phi^2 p + q, p = p- r / (p- + r), a quadratic in p.
  const double phi = test::rk4_decay(0.5, kPeriod), q = 0.04, r = 0.3;
  const double b = r * (1.0 - phi * phi) + q, p = (-b + std::sqrt(b * b + 4.0 * phi * phi * q * r)) / (2.0 * phi * phi);
  const LaneRuns runs = test::runs_of(MatrixXd::Zero(1, 2000), kPeriod);
  for (const PointSet kind : {PointSet::kExtended, PointSet::kUnscented}) {
    SigmaPointFilter filter(test::decay(0.5), kind, test::scalar_knowledge(3.0, std::sqrt(q), std::sqrt(r)), {{}}, 1);
    (void)test::estimates_of(filter, runs);
    EXPECT_NEAR(std::pow(filter.root()(0, 0)[0], 2), p, 1e-9 * p);
  }
}

TEST(SigmaPointFilter, TakesEachLaneByItsOwnTuning) {
  const VanDerPolRun run;
  const LaneRuns one = test::runs_of(run.outputs, kPeriod), two = repeated(one, 2);
  FilterTuning trusting;
  trusting.output = 0.1;
  SigmaPointFilter both(van_der_pol(), PointSet::kExtended, box_knowledge(), {{}, trusting}, 2);
  SigmaPointFilter first(van_der_pol(), PointSet::kExtended, box_knowledge(), {{}}, 1);
  SigmaPointFilter second(van_der_pol(), PointSet::kExtended, box_knowledge(), {trusting}, 1);
  double difference = 0.0;
  for (Eigen::Index k = 0; k < one.samples(); ++k) {
    const MatrixXd x = both.step(two, k);
    // Lanes beside others go through vector instructions: the same sums but for fused ones.
    EXPECT_LE((x.col(0) - first.step(one, k)).norm() + (x.col(1) - second.step(one, k)).norm(), 1e-9) << k;
    difference = std::max(difference, (x.col(0) - x.col(1)).norm());
  }
  EXPECT_GT(difference, 0.05) << "control: the tunings differ";
}

TEST(SigmaPointFilter, HoldsOutliersBeyondItsGate) {
  const VanDerPolRun run;
  MatrixXd outputs = run.outputs;
  for (Eigen::Index k = 100; k < outputs.cols(); k += 20) outputs(0, k) += 20.0;
  const auto error = [&](double gate) {
    FilterTuning tuning;
    tuning.gate = gate;
    SigmaPointFilter filter(van_der_pol(), PointSet::kExtended, box_knowledge(), {tuning}, 1);
    const MatrixXd x = test::estimates_of(filter, test::runs_of(outputs, kPeriod));
    return (x - run.truth).rightCols(300).norm() / std::sqrt(300.0);
  };
  EXPECT_LT(error(5.0), 0.1);
  EXPECT_GT(error(std::numeric_limits<double>::infinity()), 2.0 * error(5.0)) << "control: they pull without a gate";
}

TEST(SigmaPointFilter, ComesBackWhenItsGateHasLockedItOut) {
  // A state that jumps by far more than the gate: after kMostRejected samples the filter believes the sensor again.
  constexpr Eigen::Index kJump = 200;
  MatrixXd y = MatrixXd::Zero(1, 400);
  y.rightCols(400 - kJump).setConstant(10.0);
  FilterTuning tuning;
  tuning.gate = 3.5;
  SigmaPointFilter filter(test::decay(0.0), PointSet::kExtended, test::scalar_knowledge(5.0, 1e-3, 0.1), {tuning}, 1);
  const MatrixXd x = test::estimates_of(filter, test::runs_of(y, kPeriod));
  EXPECT_LT(std::abs(x(0, kJump + kMostRejected - 2)), 0.1) << "control: the jump is beyond the gate";
  EXPECT_NEAR(x(0, kJump + kMostRejected + 2), 10.0, 0.1);
}

TEST(SigmaPointFilter, StepsOverSamplesThatDidNotArrive) {
  MatrixXd y = MatrixXd::Constant(1, 50, 2.0);
  y.rightCols(20).setConstant(std::nan(""));
  SigmaPointFilter filter(test::decay(0.5), PointSet::kUnscented, test::scalar_knowledge(1.0, 1e-3, 0.1), {{}}, 1);
  const MatrixXd x = test::estimates_of(filter, test::runs_of(y, kPeriod));
  EXPECT_NEAR(x(0, 49), x(0, 29) * std::pow(test::rk4_decay(0.5, kPeriod), 20), 1e-9);
}

TEST(SigmaPointFilter, BeginsAnewWhenItLeavesTheNumbers) {
  LanePlant plant = test::decay(-400.0);  // doubles every sample and more
  SigmaPointFilter filter(plant, PointSet::kExtended, test::scalar_knowledge(1.0, 1e-3, 1e3), {{}}, 1);
  const MatrixXd x = test::estimates_of(filter, test::runs_of(MatrixXd::Constant(1, 300, 1.0), kPeriod));
  EXPECT_TRUE(x.allFinite());
  EXPECT_LE(x.cwiseAbs().maxCoeff(), 1e9);
}

TEST(HighGain, ConvergesWithoutNoiseAndLetsMoreThroughTheFasterItIs) {
  const VanDerPolRun run;
  const auto settled_error = [&](const MatrixXd& outputs, double process) {
    FilterTuning tuning;
    tuning.process = process;
    HighGainObserver observer(van_der_pol(), box_knowledge(), {tuning}, 1, kPeriod);
    const MatrixXd x = test::estimates_of(observer, test::runs_of(outputs, kPeriod));
    return (x - run.truth).rightCols(200).norm() / std::sqrt(200.0);
  };
  EXPECT_LT(settled_error(run.truth.topRows(1), 1.0), 1e-6);
  EXPECT_GT(settled_error(run.outputs, 10.0), 1.5 * settled_error(run.outputs, 1.0));
}

}  // namespace
}  // namespace nlo::trainer
