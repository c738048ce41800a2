// SPDX-License-Identifier: MIT
// The pairs (z, x) from which the supervised baseline learns, on a linear plant: T solves the Sylvester equation T A =
// D T + F C, and each unmasked pair must satisfy z = T x.
#include "trainer/data/transient.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/sensitivity/plain_latent.h"
#include "tests/support/thrown_message.h"
#include "trainer/plants/lead_in.h"
#include "trainer/plants/linear.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"
#include "trainer/rollout/rollout.h"
#include "trainer/structures/make_dynamics.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

constexpr double kOmega = 1.7;
const std::vector<double> kEigenvalues = {-1.0, -3.0};
const Eigen::Vector2d kInitial(1.0, -0.5);

LinearPlant oscillator() {
  const Eigen::Matrix2d a = (Eigen::Matrix2d() << 0.0, 1.0, -kOmega * kOmega, 0.0).finished();
  return {"oscillator", channels({"x1", "x2"}), channels({"y"}), a, Eigen::RowVector2d(1.0, 0.0)};
}

SimulationConfig sampled(double period_s) {
  SimulationConfig config;
  config.horizon_s = 12.0;
  config.sample_period_s = period_s;
  return config;
}

/// T, row by row: t_i (A - lambda_i) = C, for F = ones.
Eigen::MatrixXd sylvester(const LinearPlant& plant) {
  Eigen::MatrixXd t(2, 2);
  for (Eigen::Index i = 0; i < 2; ++i) {
    const Eigen::Matrix2d shifted = plant.a() - kEigenvalues[static_cast<std::size_t>(i)] * Eigen::Matrix2d::Identity();
    t.row(i) = plant.c() * shifted.inverse();
  }
  return t;
}

/// z - T x at all samples, with z = 0 at the first of them.
Eigen::MatrixXd residual(const LinearPlant& plant, const Trajectory& run, double period_s) {
  const std::vector<double> y(run.outputs.row(0).begin(), run.outputs.row(0).end());
  const std::vector<double> steps(y.size() - 1, period_s);
  Eigen::MatrixXd z(2, run.samples());
  for (Eigen::Index i = 0; i < 2; ++i) {
    const auto row =
        testing::plain_filter(Hold::kFirstOrder, kEigenvalues[static_cast<std::size_t>(i)], 1.0, false, y, steps);
    for (Eigen::Index k = 0; k < run.samples(); ++k) z(i, k) = row[static_cast<std::size_t>(k)].real();
  }
  return z - sylvester(plant) * run.states;
}

/// Returns the largest |z - T x| over the unmasked samples.
double worst(const Eigen::MatrixXd& residual, const Trajectory& run) {
  return (residual.array().abs().colwise().maxCoeff() * run.weight.transpose().array()).maxCoeff();
}

Trajectory with_lead_in(const LinearPlant& plant, double period_s, double k) {
  Dataset data = simulate_from(plant, sampled(period_s), kInitial);
  add_lead_in(plant, k / 1.0, k, data);
  return data.trajectories[0];
}

// Linear interpolation between samples differs from the harmonic by (omega h)^2 / 12 of its amplitude, and |T| < 1
// here.
double ramp_error(double period_s) {
  return std::pow(kOmega * period_s, 2) / 12.0;
}

constexpr double kLong = 25.0;  // exp(-25) = 1e-11: the filter has forgotten its initial state

TEST(Transient, LastsKTimeConstantsOfTheSlowestEigenvalue) {
  ObserverConfig observer;
  observer.eigenvalues = {-2.0, -0.5};
  observer.pairs = {{-4.0, 9.0}};
  observer.clocks_s = {100.0};  // a clock is not an eigenvalue of the filter
  EXPECT_DOUBLE_EQ(transient_time_s(observer, 5.0), 10.0);
  observer.pairs = {{-0.25, 9.0}};
  EXPECT_DOUBLE_EQ(transient_time_s(observer, 5.0), 20.0);
}

TEST(Transient, LeadInMakesAllPairsSatisfyTheMap) {
  const LinearPlant plant = oscillator();
  const Trajectory run = with_lead_in(plant, 0.02, kLong);
  EXPECT_EQ(run.weight.sum(), 601.0);
  EXPECT_LT(worst(residual(plant, run, 0.02), run), 2.0 * ramp_error(0.02));

  const Trajectory alone = simulate_from(plant, sampled(0.02), kInitial).trajectories[0];
  EXPECT_GT(worst(residual(plant, alone, 0.02), alone), 0.1) << "control: without the lead-in z(0) = 0";
}

TEST(Transient, LeadInLeavesOnlyTheErrorOfTheHoldWhichIsOfSecondOrder) {
  const LinearPlant plant = oscillator();
  const auto error = [&](double h) {
    const Trajectory run = with_lead_in(plant, h, kLong);
    return worst(residual(plant, run, h), run);
  };
  EXPECT_NEAR(std::log2(error(0.08) / error(0.04)), 2.0, 0.1);
  EXPECT_NEAR(std::log2(error(0.04) / error(0.02)), 2.0, 0.1);
}

TEST(Transient, LeadInReducesTheInitialErrorByExpMinusK) {
  // z(0) - T x(0) = -exp(-D t_c) T x(-t_c): the slow mode contributes exp(-k).
  const LinearPlant plant = oscillator();
  for (const double k : {1.0, 3.0, 6.0}) {
    constexpr double kPeriod = 0.01;
    const Trajectory run = with_lead_in(plant, kPeriod, k);
    const auto zero = static_cast<Eigen::Index>(std::lround(k / kPeriod));
    ASSERT_EQ(run.time_s(zero), 0.0);
    const double expected = -std::exp(-k) * (sylvester(plant).row(0) * run.states.col(0)).value();
    EXPECT_NEAR(residual(plant, run, kPeriod)(0, zero), expected, 2.0 * ramp_error(kPeriod)) << "k = " << k;
  }
}

TEST(Transient, LeadInIsThePastOfThePlantAtFourthOrder) {
  const LinearPlant plant = oscillator();
  const auto error = [&](double h) {
    const Trajectory run = with_lead_in(plant, h, 4.0);
    const Eigen::ArrayXd phase = kOmega * run.time_s.array();
    const Eigen::ArrayXd x1 = kInitial(0) * phase.cos() + kInitial(1) / kOmega * phase.sin();
    const auto past = (run.time_s.array() < 0.0).cast<double>();
    return ((run.states.row(0).transpose().array() - x1).abs() * past).maxCoeff();
  };
  EXPECT_GT(error(0.04), 1e-9);  // otherwise rounding hides the order
  EXPECT_NEAR(std::log2(error(0.08) / error(0.04)), 4.0, 0.1);
}

TEST(Transient, LeadInPrecedesTheRunAndIsMasked) {
  const LinearPlant plant = oscillator();
  const Trajectory before = simulate_from(plant, sampled(0.02), kInitial).trajectories[0];
  const Trajectory run = with_lead_in(plant, 0.02, 5.0);
  ASSERT_EQ(run.samples(), before.samples() + 250);
  EXPECT_EQ(run.states.rightCols(before.samples()), before.states);
  EXPECT_EQ(run.outputs.rightCols(before.samples()), before.outputs);
  EXPECT_EQ(run.time_s.tail(before.samples()), before.time_s);
  EXPECT_EQ(run.weight.tail(before.samples()), before.weight);
  EXPECT_TRUE((run.weight.head(250).array() == 0.0).all());
  EXPECT_NEAR(run.time_s(0), -5.0, 1e-12);
  EXPECT_TRUE((run.time_s.tail(run.samples() - 1).array() > run.time_s.head(run.samples() - 1).array()).all());
}

TEST(Transient, RemainingPairsAreWithinExpMinusKOfTheMap) {
  const LinearPlant plant = oscillator();
  for (const double k : {2.0, 5.0, 8.0}) {
    Dataset data = simulate_from(plant, sampled(0.005), kInitial);
    drop_transient(data, k / 1.0);
    const Trajectory& run = data.trajectories[0];
    const double start = (sylvester(plant) * kInitial).cwiseAbs().maxCoeff();
    const double error = worst(residual(plant, run, 0.005), run);
    EXPECT_LT(error, std::exp(-k) * start + 2.0 * ramp_error(0.005)) << "k = " << k;
    EXPECT_EQ(run.weight(static_cast<Eigen::Index>(std::lround(k / 0.005))), 1.0) << "the sample at t_c is used";
    EXPECT_EQ(run.weight(static_cast<Eigen::Index>(std::lround(k / 0.005)) - 1), 0.0);
    if (k < 3.0) {
      EXPECT_GT(error, 0.5 * std::exp(-k) * start) << "control: there is a transient to drop";
    }
  }
}

TEST(Transient, DropKeepsEarlierMasks) {
  Dataset data = simulate_from(oscillator(), sampled(0.02), kInitial);
  data.trajectories[0].weight.tail(10).setZero();
  drop_transient(data, 1.0);
  EXPECT_EQ(data.trajectories[0].weight.sum(), 601.0 - 50.0 - 10.0);
}

TEST(Transient, FilterOfTheTrainingGivesTheSamePairs) {
  // The float32 filter of the objective: z of whole runs, with the weights of the data.
  const LinearPlant plant = oscillator();
  Experiment experiment;
  experiment.observer.eigenvalues = kEigenvalues;
  experiment.training.transient = Transient::kBackward;
  experiment.training.transient_factor = 12.0;
  Dataset data = simulate_from(plant, sampled(0.01), kInitial);
  keep_out_transient(experiment, plant, data);

  const ObserverStructure structure = make_structure(experiment, false, data.outputs, data.states);
  const TrainingData training(data);
  const auto dynamics = make_dynamics(experiment, structure, training.steps_s, 1);
  dynamics->prepare(initial_dynamics(structure, experiment).data());
  ThreadPool pool(1);
  Rollout rollout(training);
  rollout.run(whole_runs(training), *dynamics, {}, 1, Purpose::kNoise, 0, pool);

  const SegmentGroup& group = rollout.groups()[0];
  const Eigen::MatrixXd expected = sylvester(plant) * data.trajectories[0].states;
  constexpr double kFloat = 1e-5;  // 1,200 steps of 6e-8, forgotten at the rate of the filter
  int counted = 0;
  for (int k = 0; k < group.length; ++k) {
    if (training.runs[0].weight[static_cast<std::size_t>(k)] == 0.0F) continue;
    ++counted;
    for (int i = 0; i < 2; ++i)
      ASSERT_NEAR(static_cast<double>(group.latent[group.at(i, k)]), expected(i, k),
                  2.0 * ramp_error(0.01) + std::exp(-12.0) + kFloat);
  }
  EXPECT_EQ(counted, 1201);
}

std::string lead_in_error(const Plant& plant, const Eigen::MatrixXd& initial, double length_s, double factor) {
  Dataset data = simulate_from(plant, sampled(0.02), initial);
  return thrown_message([&] { add_lead_in(plant, length_s, factor, data); });
}

TEST(Transient, NamesWhereTheBackwardFlowEscapes) {
  PlantConfig config;
  config.model = "van_der_pol";
  const auto plant = make_plant(config);
  Eigen::MatrixXd initial(2, 2);
  initial << 0.5, 3.0, 0.5, 2.0;  // inside and outside of the limit cycle
  const std::string message = lead_in_error(*plant, initial, 5.0, 5.0);
  EXPECT_THAT(message, HasSubstr("plant van_der_pol: backwards from x(0) = (3, 2)"));
  EXPECT_THAT(message, HasSubstr("at t = -0."));
  EXPECT_THAT(message, HasSubstr("use \"drop\""));
  EXPECT_EQ(lead_in_error(*plant, initial.leftCols(1), 5.0, 5.0), "no error")
      << "control: inside, it ends at the equilibrium";
}

TEST(Transient, RefusesAPastThatGrowsFasterThanTheFilterDecays) {
  // x' = -a x grows backwards as exp(a t_c); with lambda = -1 and t_c = k the filter forgets by exp(-k).
  const auto decaying = [](double a) {
    const Eigen::MatrixXd one = Eigen::MatrixXd::Ones(1, 1);
    return LinearPlant("decaying", channels({"x"}), channels({"y"}), -a * one, one);
  };
  const Eigen::MatrixXd initial = Eigen::MatrixXd::Ones(1, 1);
  EXPECT_THAT(lead_in_error(decaying(1.1), initial, 5.0, 5.0), HasSubstr("grows faster than the filter forgets"));
  EXPECT_EQ(lead_in_error(decaying(0.9), initial, 5.0, 5.0), "no error");
}

TEST(Transient, DropNamesTheRunThatIsTooShort) {
  Dataset data = simulate_from(oscillator(), sampled(0.02), kInitial);
  EXPECT_THAT(thrown_message([&] { drop_transient(data, 12.5); }),
              HasSubstr("simulation 0: transient = \"drop\" leaves no sample, because the run lasts 12 s"));
}

}  // namespace
}  // namespace nlo::trainer
