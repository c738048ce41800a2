// SPDX-License-Identifier: MIT
#include "trainer/judge/filters/sigma_point_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/filters/lanes.h"
#include "tests/filters/linear_chain.h"
#include "trainer/config/experiment.h"
#include "trainer/judge/filters/high_gain.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;

using test::Chain;
using test::chain_knowledge;
using test::IrregularRun;
using test::kalman_recursion;

constexpr double kPeriod = 0.02;

LanePlant van_der_pol() {
  PlantConfig config;
  config.model = "van_der_pol";
  return lane_plant(make_plant(config));
}

/// True states and noisy output of one run of 10 s.
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
  return {Vector2d::Zero(), Eigen::Matrix2d::Identity() / 3.0, Vector2d::Constant(1e-3), VectorXd::Constant(1, 0.5)};
}

// Tolerance: rounding of a linear map divided by a difference step of 1e-4 of a standard deviation.
constexpr double kSameFilter = 1e-8;

TEST(SigmaPointFilter, EqualsTheKalmanFilterForALinearPlant) {
  const IrregularRun run;
  for (const PointSet kind : {PointSet::kExtended, PointSet::kUnscented})
    for (const Index n : {1, 2, 3, 5})
      for (const bool held : {true, false}) {
        const Chain chain(n);
        const auto largest_difference = [&](const FilterKnowledge& known) {
          SigmaPointFilter filter(chain.plant(), kind, known, {{}}, 1);
          const MatrixXd x = test::estimates_of(filter, one_run(run.y, run.u, run.time_s, held));
          return (x - kalman_recursion(chain, chain_knowledge(n), run, held)).cwiseAbs().maxCoeff();
        };
        EXPECT_LT(largest_difference(chain_knowledge(n)), kSameFilter) << n << " states";
        for (VectorXd FilterKnowledge::*each : {&FilterKnowledge::output_deviation, &FilterKnowledge::process_noise}) {
          FilterKnowledge other = chain_knowledge(n);
          (other.*each)[0] *= 1.5;
          EXPECT_GT(largest_difference(other), 1e-3) << "control: each of these values matters";
        }
      }
}

TEST(SigmaPointFilter, DividesLongSamplePeriods) {
  // A period of 4 s is beyond the stability limit of RK4 for x' = -x: one step grows, steps of a tenth do not.
  const auto decayed = [](double longest_step_s) {
    LanePlant plant = test::decay(1.0);
    plant.longest_step_s = longest_step_s;
    return advance(plant, MatrixXd::Ones(1, 1), 4.0, {})(0, 0);
  };
  EXPECT_NEAR(decayed(0.1), std::exp(-4.0), 1e-5);
  EXPECT_GT(std::abs(decayed(4.0)), 1.0) << "control";
}

TEST(SigmaPointFilter, KeepsAnExactlyKnownInitialState) {
  const IrregularRun run;
  for (const PointSet kind : {PointSet::kExtended, PointSet::kUnscented})
    for (const double variance : {0.0, 1.0}) {
      FilterKnowledge known = {VectorXd::Zero(2), variance * MatrixXd::Identity(2, 2), VectorXd::Zero(2),
                               Vector2d(0.5, 0.3)};
      SigmaPointFilter filter(Chain(2).plant(), kind, known, {{}}, 1);
      const MatrixXd x = test::estimates_of(filter, one_run(run.y, 0.0 * run.u, run.time_s, true));
      if (variance == 0.0)
        EXPECT_EQ(x.cwiseAbs().maxCoeff(), 0.0);
      else
        EXPECT_GT(x.cwiseAbs().maxCoeff(), 0.1) << "control";
    }
}

TEST(SigmaPointFilter, ComputesTheInnovationOfAnAngleTheShortWayRound) {
  // dx1/dt = x2 = 5 rad/s: an angle that wraps five times in 6 s.
  constexpr double kTurn = 2.0 * 3.141592653589793;
  const VectorXd time_s = VectorXd::LinSpaced(301, 0.0, 6.0);
  const MatrixXd y = (5.0 * time_s.transpose()).unaryExpr([](double angle) { return std::remainder(angle, kTurn); });
  const auto rate_error = [&](PointSet kind, double wrap) {
    LanePlant plant;
    plant.nx = 2;
    plant.ny = 1;
    plant.f = [](const MatrixXd& x, const MatrixXd&) {
      return MatrixXd((Eigen::Matrix2d() << 0.0, 1.0, 0.0, 0.0).finished() * x);
    };
    plant.h = [](const MatrixXd& x, const MatrixXd&) { return MatrixXd(x.topRows<1>()); };
    plant.output_wraps = VectorXd::Constant(1, wrap);
    // The points of the UKF must stay within half a turn of each other.
    const FilterKnowledge known = {VectorXd::Zero(2), 2.0 * MatrixXd::Identity(2, 2), VectorXd::Constant(2, 1e-3),
                                   VectorXd::Constant(1, 0.1)};
    SigmaPointFilter filter(plant, kind, known, {{}}, 1);
    return std::abs(test::estimates_of(filter, one_run(y, {}, time_s, false))(1, 300) - 5.0);
  };
  for (const PointSet kind : {PointSet::kExtended, PointSet::kUnscented}) {
    EXPECT_LT(rate_error(kind, kTurn), 1e-2);
    EXPECT_GT(rate_error(kind, 0.0), 1.0) << "control: the jumps are large";
  }
}

TEST(SigmaPointFilter, RestartsAfterAnOutlierThatMakesItsStepOverflow) {
  // dx/dt = -x^3 is very stable, but RK4 with steps of 0.1 s overflows from x = 1e7.
  LanePlant plant = test::decay(0.0);
  plant.f = [](const MatrixXd& x, const MatrixXd&) { return MatrixXd(-x.array().cube()); };
  constexpr double kOutlier = 1e7;
  ASSERT_FALSE((advance(plant, MatrixXd::Constant(1, 1, kOutlier), 0.1, {}).array().abs() <= 1e9).all())
      << "control: without a restart all later estimates would be NaN";
  constexpr Index kSamples = 40, kAt = 20;
  MatrixXd y = MatrixXd::Constant(1, kSamples, 0.2);
  y(0, kAt) = kOutlier;
  for (const PointSet kind : {PointSet::kExtended, PointSet::kUnscented}) {
    // Process noise of 1: the filters trust the measurement, gain 0.99.
    SigmaPointFilter filter(plant, kind, test::scalar_knowledge(1.0, 1.0, 0.1), {{}}, 1);
    const MatrixXd x = test::estimates_of(filter, test::runs_of(y, 0.1));
    ASSERT_TRUE(x.allFinite());
    EXPECT_NEAR(x(0, kAt - 1), 0.2, 0.02);
    EXPECT_NEAR(x(0, kSamples - 1), 0.2, 0.02);  // the steady gain is near 1
  }
}

TEST(SigmaPointFilter, DependsOnTheChoiceOfPointsForANonlinearPlant) {
  const VanDerPolRun run;
  SigmaPointFilter extended(van_der_pol(), PointSet::kExtended, box_knowledge(), {{}}, 1);
  SigmaPointFilter unscented(van_der_pol(), PointSet::kUnscented, box_knowledge(), {{}}, 1);
  const LaneRuns lanes = test::runs_of(run.outputs, kPeriod);
  EXPECT_GT((test::estimates_of(extended, lanes) - test::estimates_of(unscented, lanes)).cwiseAbs().maxCoeff(), 1e-3);
}

TEST(SigmaPointFilter, SettlesAtTheCovarianceOfTheRiccatiEquation) {
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

TEST(SigmaPointFilter, GivesEachLaneItsOwnTuning) {
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
    // Several lanes use vector instructions: the same sums except for fused multiply-adds.
    EXPECT_LE((x.col(0) - first.step(one, k)).norm() + (x.col(1) - second.step(one, k)).norm(), 1e-9) << k;
    difference = std::max(difference, (x.col(0) - x.col(1)).norm());
  }
  EXPECT_GT(difference, 0.05) << "control: the tunings differ";
}

TEST(SigmaPointFilter, AFactorOnEachStateEqualsOneFactorOnAll) {
  const VanDerPolRun run;
  const LaneRuns lanes = test::runs_of(run.outputs, kPeriod);
  const auto estimates = [&](const FilterTuning& tuning) {
    SigmaPointFilter filter(van_der_pol(), PointSet::kExtended, box_knowledge(), {tuning}, 1);
    return test::estimates_of(filter, lanes);
  };
  FilterTuning whole, each;
  whole.process = 1e4;
  whole.initial = 0.25;
  each.process_of = {1e4, 1e4};
  each.initial_of = {0.25, 0.25};
  EXPECT_LE((estimates(whole) - estimates(each)).cwiseAbs().maxCoeff(), 1e-12);
  each.process_of[1] = 1.0;
  EXPECT_GT((estimates(whole) - estimates(each)).cwiseAbs().maxCoeff(), 1e-3)
      << "control: a factor on a single state differs";
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
  EXPECT_GT(error(std::numeric_limits<double>::infinity()), 2.0 * error(5.0))
      << "control: outliers pull without a gate";
}

TEST(SigmaPointFilter, AcceptsMeasurementsAgainAfterManyRejections) {
  // A state jumps by much more than the gate: after kMostRejected samples the filter accepts the measurements again.
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

TEST(SigmaPointFilter, PredictsOverMissingSamples) {
  MatrixXd y = MatrixXd::Constant(1, 50, 2.0);
  y.rightCols(20).setConstant(std::nan(""));
  SigmaPointFilter filter(test::decay(0.5), PointSet::kUnscented, test::scalar_knowledge(1.0, 1e-3, 0.1), {{}}, 1);
  const MatrixXd x = test::estimates_of(filter, test::runs_of(y, kPeriod));
  EXPECT_NEAR(x(0, 49), x(0, 29) * std::pow(test::rk4_decay(0.5, kPeriod), 20), 1e-9);
}

TEST(SigmaPointFilter, RestartsIfItOverflows) {
  LanePlant plant = test::decay(-400.0);  // doubles every sample and more
  SigmaPointFilter filter(plant, PointSet::kExtended, test::scalar_knowledge(1.0, 1e-3, 1e3), {{}}, 1);
  const MatrixXd x = test::estimates_of(filter, test::runs_of(MatrixXd::Constant(1, 300, 1.0), kPeriod));
  EXPECT_TRUE(x.allFinite());
  EXPECT_LE(x.cwiseAbs().maxCoeff(), 1e9);
}

TEST(HighGain, ConvergesWithoutNoiseAndAmplifiesNoiseMoreIfItIsFaster) {
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
