// SPDX-License-Identifier: MIT
// The linear readout. Also [inverse_map] error, which adds an error head to a model and changes nothing else.
#include "trainer/judge/evaluation/linear_readout.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "codegen/base/error.h"
#include "codegen/model_file/model_file.h"
#include "tests/evaluation/van_der_pol_set.h"
#include "tests/training/training_testing.h"
#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

/// T* reads (z1, z2 - y) and estimates two states, of which the second is an angle.
codegen::Model reader() {
  codegen::Model model;
  model.outputs = {{"y", "", 0.0}};
  model.states = {{"x", "m", 0.0}, {"angle", "rad", kTurn}};
  model.sample_period_s = 0.01;
  model.initial_latent = Eigen::VectorXd::Zero(2);
  codegen::inverse_map(model)->features.resize(2, 3);
  codegen::inverse_map(model)->features << 1.0, 0.0, 0.0, 0.0, 1.0, -1.0;
  codegen::inverse_map(model)->feature_mean = Eigen::Vector2d(3.0, -1.0);
  codegen::inverse_map(model)->feature_scale = Eigen::Vector2d(0.1, 20.0);
  return model;
}

/// A run whose angle makes a full turn; x is a linear function of the features, and of sine and cosine of the angle.
std::pair<codegen::Run, Trajectory> turning_run() {
  constexpr Eigen::Index kSamples = 200;
  codegen::Run run{Eigen::MatrixXd(), Eigen::MatrixXd(2, kSamples), Eigen::MatrixXd(1, kSamples)};
  Trajectory truth{"run",
                   Eigen::VectorXd::LinSpaced(kSamples, 0.0, 1.0),
                   {},
                   Eigen::MatrixXd(2, kSamples),
                   Eigen::VectorXd::Ones(kSamples)};
  for (Eigen::Index k = 0; k < kSamples; ++k) {
    const double angle = kTurn * static_cast<double>(k) / 100.0;  // unwrapped, up to two turns
    run.z.col(k) << std::sin(angle), std::cos(angle) + 0.1 * angle;
    run.y(0, k) = 0.1 * angle;
    truth.states.col(k) << 5.0 - 2.0 * std::sin(angle) + 3.0 * std::cos(angle), angle;
  }
  return {run, truth};
}

TEST(LinearReadout, FindsALinearMapOfTheFeaturesAndAnglesBySineAndCosine) {
  const auto run = turning_run();
  LinearReadout readout(reader(), 0.0);
  readout.add(run.first, run.second);
  readout.fit();
  const Eigen::MatrixXd estimate = readout.estimate(run.first);
  constexpr double kRidgeBias = 1e-4;  // a ridge of 1e-6 changes coefficients of order 5 by about 1e-5
  for (Eigen::Index k = 0; k < estimate.cols(); ++k) {
    ASSERT_NEAR(estimate(0, k), run.second.states(0, k), kRidgeBias) << k;
    ASSERT_NEAR(std::remainder(estimate(1, k) - run.second.states(1, k), kTurn), 0.0, kRidgeBias) << k;
  }
}

TEST(LinearReadout, MaskedTruthDoesNotCount) {
  auto run = turning_run();
  run.second.weight.head(50).setZero();
  run.second.states.leftCols(50).setConstant(std::numeric_limits<double>::quiet_NaN());
  LinearReadout readout(reader(), 0.0);
  readout.add(run.first, run.second);
  readout.fit();
  EXPECT_NEAR(readout.estimate(run.first)(0, 120), run.second.states(0, 120), 1e-4);
}

TEST(LinearReadout, TransientDoesNotChangeTheFitOfTheSettledSamples) {
  constexpr Eigen::Index kTransient = 60;
  auto run = turning_run();
  run.second.states.row(0).head(kTransient).array() += 1000.0;  // not a function of the features
  const double period_s = reader().sample_period_s;
  const auto error_behind = [&](double settled_from_s) {
    LinearReadout readout(reader(), settled_from_s);
    readout.add(run.first, run.second);
    readout.fit();
    const Eigen::MatrixXd off = readout.estimate(run.first) - run.second.states;
    return off.row(0).tail(200 - kTransient).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(error_behind(static_cast<double>(kTransient) * period_s), 1e-4) << "only the bias of the ridge of 1e-6";
  EXPECT_GT(error_behind(0.0), 1.0) << "control: one fit over all samples";
}

TEST(LinearReadout, IsRefusedWithoutData) {
  EXPECT_THROW(LinearReadout(reader(), 0.0).fit(), codegen::Error);
}

Experiment oscillator_experiment() {
  Experiment experiment = testing::small_experiment();
  experiment.inverse_map.hidden = {12};
  experiment.training.steps = 600;
  experiment.training.samples_per_step = 1000;
  experiment.training.noise = {NoiseKind::kGaussian, 0.2};
  return experiment;
}

codegen::Model trained(Experiment experiment, bool error) {
  experiment.inverse_map.error = error;
  return train(experiment, test::van_der_pol_set(40, 20.0, 1, 2.0), test::van_der_pol_set(40, 20.0, 2, 2.0), {}).model;
}

TEST(ErrorTraining, ChangesNothingElseInTheModel) {
  Experiment experiment = oscillator_experiment();
  experiment.training.steps = 20;
  codegen::Model with = trained(experiment, true);
  ASSERT_TRUE(with.error);
  with.error.reset();
  EXPECT_EQ(codegen::to_json(with), codegen::to_json(trained(experiment, false)));
}

TEST(ErrorTraining, GivesTheSameBytesForAnyNumberOfThreads) {
  Experiment experiment = oscillator_experiment();
  experiment.training.steps = 20;
  const std::string one = codegen::to_json(trained(experiment, true));
  experiment.threads = 3;
  EXPECT_EQ(codegen::to_json(trained(experiment, true)), one);
}

TEST(ErrorTraining, CoversItsNominalShareOnNewRuns) {
  const codegen::Model model = trained(oscillator_experiment(), true);
  const Dataset fresh = test::van_der_pol_set(100, 20.0, 3, 2.0);
  const NoiseConfig noise{NoiseKind::kGaussian, 0.2};
  const auto found = evaluate("", observer_estimator(model, true), fresh, noise, 7, 1).coverage;
  ASSERT_TRUE(found);
  // The errors of a run are correlated over about 2 s: 100 runs of 20 s count as 1,000 draws, the 40 runs of the
  // calibration as 400. Tolerance: four deviations of the difference, 4 sqrt(p (1 - p) (1 / 1000 + 1 / 400)).
  const auto tolerance = [](double p) { return 4.0 * std::sqrt(p * (1.0 - p) * (1.0 / 1000.0 + 1.0 / 400.0)); };
  for (Eigen::Index i = 0; i < 2; ++i) {
    EXPECT_NEAR(found->share_68(i), 0.68, tolerance(0.68)) << i;
    EXPECT_NEAR(found->share_95(i), 0.95, tolerance(0.95)) << i;
  }

  codegen::Model wrong = model;  // control: a sigma that is wrong by a third is detected
  wrong.error->factor_68 *= 1.4;
  const auto seen = evaluate("", observer_estimator(wrong, true), fresh, noise, 7, 1).coverage;
  for (Eigen::Index i = 0; i < 2; ++i) EXPECT_GT(std::abs(seen->share_68(i) - 0.68), tolerance(0.68)) << i;
}

}  // namespace
}  // namespace nlo::trainer
