// SPDX-License-Identifier: MIT
// A linear plant has a known solution. For x' = A x, y = C x the transformation T solves T A = D T + F C (Sylvester),
// T* is its left inverse, and the error decays as T* exp(D t) (z_0 - T x_0).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <vector>

#include "codegen/base/linear_algebra.h"
#include "tests/support/thrown_message.h"
#include "tests/training/training_testing.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/observer_gain.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr double kOmega = 1.7;
constexpr double kPeriod = 0.02;
constexpr double kTransient_s = 12.0;  // exp(-12 |lambda|) is below 1e-10 for all eigenvalues here

const Eigen::Matrix2d kPlant = (Eigen::Matrix2d() << 0.0, 1.0, -kOmega* kOmega, 0.0).finished();
const Eigen::RowVector2d kOutput(1.0, 0.0);

Eigen::Vector2d oscillation(const Eigen::Vector2d& x0, double time_s) {
  const double c = std::cos(kOmega * time_s);
  const double s = std::sin(kOmega * time_s);
  return {c * x0(0) + s / kOmega * x0(1), -kOmega * s * x0(0) + c * x0(1)};
}

Trajectory oscillator_run(const Eigen::Vector2d& x0, double horizon_s, double masked_s) {
  const int samples = static_cast<int>(std::lround(horizon_s / kPeriod)) + 1;
  Trajectory run;
  run.source = "oscillator";
  run.time_s = Eigen::VectorXd::LinSpaced(samples, 0.0, kPeriod * (samples - 1));
  run.states.resize(2, samples);
  run.weight.resize(samples);
  for (int k = 0; k < samples; ++k) {
    run.states.col(k) = oscillation(x0, run.time_s(k));
    run.weight(k) = run.time_s(k) < masked_s ? 0.0 : 1.0;
  }
  run.outputs = kOutput * run.states;
  return run;
}

Dataset oscillator(double masked_s) {
  Dataset data;
  data.outputs = {{"y", "", 0.0}};
  data.states = {{"position", "", 0.0}, {"velocity", "", 0.0}};
  data.sample_period_s = kPeriod;
  for (const Eigen::Vector2d& x0 :
       {Eigen::Vector2d(1.0, 0.0), Eigen::Vector2d(-0.5, 1.5), Eigen::Vector2d(0.2, -2.0), Eigen::Vector2d(2.0, 1.0)}) {
    data.trajectories.push_back(oscillator_run(x0, 30.0, masked_s));
  }
  return data;
}

/// T of T A = D T + F C, row by row: t_i (A - lambda_i) = f_i C.
Eigen::MatrixXd sylvester(const codegen::Model& model) {
  Eigen::MatrixXd t(model.nz(), 2);
  for (int i = 0; i < model.nz(); ++i) {
    const Eigen::Matrix2d shifted =
        kPlant - codegen::linear_latent(model)->eigenvalues(i) * Eigen::Matrix2d::Identity();
    t.row(i) =
        codegen::linear_latent(model)->output_injection(i, 0) * kOutput * codegen::inverse(Eigen::MatrixXd(shifted));
  }
  return t;
}

/// The linear map from z to the estimate in the trained model: last layer plus linear path, without scales and
/// features.
Eigen::MatrixXd trained_map(const codegen::Model& model) {
  const Eigen::MatrixXd whole = codegen::inverse_map(model)->layers.back().weights + codegen::inverse_map(model)->skip;
  return codegen::inverse_map(model)->output_scale.asDiagonal() * whole *
         codegen::inverse_map(model)->feature_scale.cwiseInverse().asDiagonal() *
         codegen::inverse_map(model)->features.leftCols(model.nz());
}

codegen::Model train_linear(const std::vector<double>& eigenvalues) {
  Experiment experiment = testing::small_experiment();
  experiment.observer.pairs = {};
  experiment.observer.eigenvalues = eigenvalues;
  experiment.observer.learn_eigenvalues = false;
  experiment.inverse_map.hidden = {};
  experiment.inverse_map.linear_path = true;
  experiment.inverse_map.ridge = 1e-12;
  experiment.training.steps = 400;
  experiment.training.mode = TrainingMode::kFullBatch;
  experiment.training.learning_rate = 1e-2;
  experiment.training.validate_every = 20;
  return train(experiment, oscillator(kTransient_s), oscillator(kTransient_s), {}).model;
}

// The linear interpolation between samples differs from the harmonic by (omega h)^2 / 12 = 1e-4 of y; the accuracy of
// float32 training is similar.
constexpr double kTolerance = 2e-3;

TEST(LinearPlant, TrainingFindsTheInverseOfTheSylvesterSolution) {
  const codegen::Model model = train_linear({-1.0, -3.0});
  const Eigen::MatrixXd t = sylvester(model);
  const Eigen::MatrixXd expected = codegen::least_squares(t, Eigen::MatrixXd::Identity(t.rows(), t.rows()));
  EXPECT_LT((trained_map(model) - expected).cwiseAbs().maxCoeff(), kTolerance * expected.cwiseAbs().maxCoeff())
      << "trained\n"
      << trained_map(model) << "\nclosed form\n"
      << expected;
}

TEST(LinearPlant, WithMoreLatentStatesThanStatesTrainingFindsALeftInverse) {
  const codegen::Model model = train_linear({-1.0, -2.0, -4.0});
  const Eigen::Matrix2d product = trained_map(model) * sylvester(model);
  EXPECT_LT((product - Eigen::Matrix2d::Identity()).cwiseAbs().maxCoeff(), 5.0 * kTolerance) << product;
}

TEST(LinearPlant, ErrorOfTheTrainedObserverDecaysAsInTheClosedForm) {
  const codegen::Model model = train_linear({-1.0, -3.0});
  const Eigen::MatrixXd t = sylvester(model);
  const Eigen::Vector2d x0(0.7, -1.1);  // not a run of the training set
  const Trajectory run = oscillator_run(x0, 8.0, 0.0);
  const Eigen::MatrixXd error = testing::plain_estimates(model, run).states - run.states;
  const Eigen::MatrixXd left_inverse = codegen::least_squares(t, Eigen::MatrixXd::Identity(t.rows(), t.rows()));
  const double start = (left_inverse * t * x0).norm();
  for (Eigen::Index k = 0; k < run.samples(); ++k) {
    const Eigen::VectorXd decay = (codegen::linear_latent(model)->eigenvalues * run.time_s(k)).array().exp();
    const Eigen::Vector2d expected = -left_inverse * decay.asDiagonal() * t * x0;  // z_0 = 0
    ASSERT_LT((error.col(k) - expected).norm(), 5.0 * kTolerance * start) << "at " << run.time_s(k) << " s";
  }
  EXPECT_GT(error.col(0).norm(), 0.5 * start) << "control: there is an error to decay";
}

std::vector<double> real_parts(const MatrixXd& m) {
  const Eigen::VectorXcd values = codegen::eigenvalues(m);
  std::vector<double> parts;
  for (const auto& value : values) parts.push_back(value.real());
  std::sort(parts.begin(), parts.end());
  return parts;
}

MatrixXd chain(int n) {
  MatrixXd a = MatrixXd::Zero(n, n);
  for (int i = 0; i + 1 < n; ++i) a(i, i + 1) = 1.0;
  for (int i = 0; i < n; ++i) a(n - 1, i) = 0.3 * i - 1.0;
  return a;
}

TEST(ObserverGain, PlacesEveryPole) {
  for (const int n : {1, 2, 4}) {
    for (const int outputs : {1, 2}) {
      if (outputs > n) continue;
      MatrixXd c = MatrixXd::Zero(outputs, n);
      c(0, 0) = 1.0;
      if (outputs == 2) c(1, n - 1) = 2.0;
      VectorXd poles(n);
      for (int i = 0; i < n; ++i) poles(i) = -1.0 - i;
      const MatrixXd gain = place_poles(chain(n), c, poles);
      const std::vector<double> placed = real_parts(chain(n) - gain * c);
      for (int i = 0; i < n; ++i)
        EXPECT_NEAR(placed[static_cast<std::size_t>(i)], poles(n - 1 - i), 1e-8);  // Ackermann's formula in double
    }
  }
}

TEST(ObserverGain, RefusesUnobservableStates) {
  const MatrixXd a = MatrixXd::Identity(2, 2);  // two equal modes, one output
  EXPECT_THAT(thrown_message([&] { place_poles(a, MatrixXd::Ones(1, 2), VectorXd::Constant(2, -1.0)); }),
              HasSubstr("cannot all be seen"));
}

TEST(ObserverGain, KalmanGainOfAScalarPlantEqualsItsClosedForm) {
  // x' = a x + w, y = c x + v: p = (a + sqrt(a^2 + c^2 q / r)) r / c^2, g = p c / r.
  const double a = 0.7, c = 2.0, q = 0.5, r = 0.1;
  const double expected = (a + std::sqrt(a * a + c * c * q / r)) / c;
  const MatrixXd gain = kalman_gain(MatrixXd::Constant(1, 1, a), MatrixXd::Constant(1, 1, c), q, r);
  EXPECT_NEAR(gain(0, 0), expected, 1e-12 * expected);
}

TEST(ObserverGain, KalmanGainSolvesTheRiccatiEquation) {
  const MatrixXd a = chain(3);
  MatrixXd c(2, 3);
  c << 1.0, 0.0, 0.5, 0.0, 1.0, 0.0;
  const double q = 0.3, r = 0.2;
  const MatrixXd gain = kalman_gain(a, c, q, r);
  EXPECT_LT(real_parts(a - gain * c).back(), 0.0);
  // G = P C^T / r determines only P C^T, so the test uses the Lyapunov form (A - G C) P + P (A - G C)^T = -(q I + r G
  // G^T).
  const MatrixXd closed = a - gain * c;
  MatrixXd kronecker = MatrixXd::Zero(9, 9);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      kronecker.block(3 * i, 3 * j, 3, 3) += closed(i, j) * MatrixXd::Identity(3, 3);
      if (i == j) kronecker.block(3 * i, 3 * j, 3, 3) += closed;
    }
  const MatrixXd right = -(q * MatrixXd::Identity(3, 3) + r * gain * gain.transpose());
  const VectorXd solution = codegen::solve(kronecker, Eigen::Map<const VectorXd>(right.data(), 9));
  const MatrixXd covariance = Eigen::Map<const MatrixXd>(solution.data(), 3, 3);
  EXPECT_LT((covariance * c.transpose() / r - gain).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(ObserverGain, RefusesAGainThatDoesNotDecay) {
  LuenbergerConfig config;
  config.state_matrix = {{0.0, 1.0}, {-1.0, 0.0}};
  config.output_matrix = {{1.0, 0.0}};
  config.gain = {{-1.0}, {0.0}};
  EXPECT_THAT(thrown_message([&] { linear_part(config, 2, 1); }), HasSubstr("does not decay"));
}

}  // namespace
}  // namespace nlo::trainer
