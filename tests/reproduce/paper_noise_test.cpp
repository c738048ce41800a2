// SPDX-License-Identifier: MIT
// The paper-like metric: plant and latent system are integrated together by RK4, with a draw of noise in each stage.
#include "trainer/reproduce/paper_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "trainer/judge/evaluation/evaluate.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

constexpr double kLambda = -2.0;

/// z' = lambda z + y with T*(z) = (z, 0), for a plant of two states and one output.
codegen::Model one_latent(double h) {
  codegen::Model model;
  model.name = "one_latent";
  model.outputs = {{"y", "", 0.0}};
  model.states = {{"x1", "", 0.0}, {"x2", "", 0.0}};
  model.sample_period_s = h;
  codegen::linear_latent(model)->eigenvalues = Eigen::VectorXd::Constant(1, kLambda);
  codegen::linear_latent(model)->output_injection = Eigen::MatrixXd::Ones(1, 1);
  model.initial_latent = Eigen::VectorXd::Zero(1);
  model.output_min = Eigen::VectorXd::Constant(1, -100.0);
  model.output_max = Eigen::VectorXd::Constant(1, 100.0);
  model.latent_min = Eigen::VectorXd::Constant(1, -100.0);
  model.latent_max = Eigen::VectorXd::Constant(1, 100.0);
  codegen::inverse_map(model)->features = Eigen::RowVector2d(1.0, 0.0);
  codegen::inverse_map(model)->feature_mean = Eigen::VectorXd::Zero(1);
  codegen::inverse_map(model)->feature_scale = Eigen::VectorXd::Ones(1);
  codegen::inverse_map(model)->layers = {{Eigen::Vector2d(1.0, 0.0), Eigen::VectorXd::Zero(2)}};
  codegen::inverse_map(model)->output_mean = Eigen::VectorXd::Zero(2);
  codegen::inverse_map(model)->output_scale = Eigen::VectorXd::Ones(2);
  return model;
}

PlantConfig oscillator() {
  PlantConfig plant;
  plant.model = "harmonic_oscillator";
  return plant;
}

SimulationConfig simulation(double h, double horizon_s) {
  SimulationConfig config;
  config.sample_period_s = h;
  config.horizon_s = horizon_s;
  return config;
}

/// Error of z at 4 s against the closed form: y = cos t gives z = (lambda (e^(lambda t) - cos t) + sin t) / (1 +
/// lambda^2).
double latent_error(double h) {
  constexpr double kEnd = 4.0;
  const JointRun run = integrate_with_stage_noise(one_latent(h), *make_plant(oscillator()), simulation(h, kEnd),
                                                  Eigen::Vector2d(1.0, 0.0), {}, 1);
  const double exact =
      (kLambda * (std::exp(kLambda * kEnd) - std::cos(kEnd)) + std::sin(kEnd)) / (1.0 + kLambda * kLambda);
  return std::abs(run.latent.front()(0, run.latent.front().cols() - 1) - exact);
}

TEST(StageNoise, WithoutNoiseTheLatentStateConvergesAtFourthOrder) {
  const double ratio = latent_error(0.1) / latent_error(0.05);
  EXPECT_GT(ratio, 13.0);  // 16 as h -> 0
  EXPECT_LT(ratio, 19.0);
}

TEST(StageNoise, WithoutNoiseTheErrorEqualsThatOfTheStrictMetric) {
  const double h = 0.01;
  const Eigen::Matrix2d initial = Eigen::Vector2d(1.0, -0.5).asDiagonal();
  const Dataset clean = simulate_from(*make_plant(oscillator()), simulation(h, 10.0), initial);
  const ErrorMetrics strict = evaluate_on_plant(one_latent(h), clean, {}, 1, 1).metrics;
  const ErrorMetrics joint =
      evaluate_with_stage_noise(one_latent(h), oscillator(), simulation(h, 10.0), initial, {}, 1, 1);
  EXPECT_NEAR(joint.norm, strict.norm, h * h);  // a first-order hold of y is of second order in h
}

/// Variance of z in steady state, for a plant at rest with y = 0.
double latent_variance(const NoiseConfig& noise) {
  const Eigen::Index runs = 50;
  const JointRun run = integrate_with_stage_noise(one_latent(0.02), *make_plant(oscillator()), simulation(0.02, 100.0),
                                                  Eigen::MatrixXd::Zero(2, runs), noise, 7);
  double squares = 0.0, samples = 0.0;
  for (const Eigen::MatrixXd& z : run.latent) {
    const Eigen::Index settled = z.cols() - 250;  // 5 s: ten time constants
    squares += z.rightCols(settled).squaredNorm();
    samples += static_cast<double>(settled);
  }
  return squares / samples;
}

TEST(StageNoise, IsAveragedOverTheStagesOfAStep) {
  // z+ = R z + (h / 6) sum c_i v_i with q = lambda h: the RK4 stages of a linear equation, expanded.
  const double h = 0.02, q = kLambda * h, sigma = 0.5;
  const double growth = 1.0 + q + q * q / 2.0 + q * q * q / 6.0 + q * q * q * q / 24.0;
  const double c[] = {1.0 + q + q * q / 2.0 + q * q * q / 4.0, 2.0 + q + q * q / 2.0, 2.0 + q, 1.0};
  double power = 0.0;
  for (const double each : c) power += each * each;
  const double expected = sigma * sigma * (h / 6.0) * (h / 6.0) * power / (1.0 - growth * growth);
  // 50 runs of 95 s with a correlation time of 1/2 s: about 9,500 independent samples, so the variance is known to 1.5
  // %.
  EXPECT_NEAR(latent_variance({NoiseKind::kGaussian, sigma}) / expected, 1.0, 0.05);
  // Control: one draw held over the step would have a variance 36/10 as large.
  EXPECT_GT(sigma * sigma * h * h / (1.0 - growth * growth) / expected, 3.0);
}

TEST(StageNoise, GivesTheSameBytesForAnyNumberOfThreads) {
  Eigen::MatrixXd initial(2, 45);  // more than two chunks
  for (Eigen::Index i = 0; i < initial.cols(); ++i) initial.col(i) << 0.02 * static_cast<double>(i), 1.0;
  const auto norm = [&](int threads) {
    return evaluate_with_stage_noise(one_latent(0.02), oscillator(), simulation(0.02, 2.0), initial,
                                     {NoiseKind::kUniform, 3.0}, 3, threads)
        .norm;
  };
  EXPECT_EQ(norm(1), norm(3));
}

}  // namespace
}  // namespace nlo::trainer
