// SPDX-License-Identifier: MIT
// If training declares a sensor defect, the error in flight with the defect falls. The control of each defect is a
// training without it.
#include <gtest/gtest.h>

#include <string>

#include "tests/training/training_testing.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

Experiment pushed_mass(const std::string& training) {
  Experiment experiment = parse_experiment(
      "name = \"pushed_mass\"\n[plant]\nstates = [\"x1\", \"x2\"]\ninputs = [\"u\"]\n"
      "derivative = [\"x2\", \"-4 * x1 - 0.4 * x2 + u\"]\noutputs = [\"x1\"]\n"
      "[excitation]\nkinds = [\"steps\"]\nlow = [-4]\nhigh = [4]\nshortest_s = 0.2\nlongest_s = 2.0\n"
      "[simulation]\nhorizon_s = 15.0\nsample_period_s = 0.05\ntrajectories = 12\ninitial_low = [-1.0, -1.0]\n"
      "initial_high = [1.0, 1.0]\n[observer]\neigenvalues = [-2.0, -4.0, -8.0]\nlearn_eigenvalues = false\n"
      "features = \"latent_and_output\"\n[inverse_map]\nhidden = [12]\nlinear_path = true\nridge = 1e-9\n[training]\n"
      "steps = 1500\nlearning_rate = 3e-3\ntrajectories_per_step = 8\nsamples_per_step = 400\n" +
          training,
      "pushed_mass.toml");
  experiment.threads = 1;
  return experiment;
}

/// Error over the last 200 samples, with sensors as declared by `noise` and `input_noise`.
double settled_error(const codegen::Model& model, Dataset data, const std::string& noise,
                     const std::string& input_noise) {
  for (std::size_t i = 0; i < data.trajectories.size(); ++i) {
    Trajectory& run = data.trajectories[i];
    run.outputs = MeasurementNoise(parse_noise(noise), 1, i).on(run.outputs);
    run.inputs = held(MeasurementNoise(parse_noise(input_noise), 2, i).on(run.inputs));
  }
  return testing::settled_rmse(model, data, 200);
}

struct Gain {
  double declared, not_declared;
};

Gain gain(const std::string& noise, const std::string& input_noise) {
  const TrainingSets sets = simulate_training_sets(pushed_mass(""));
  const Experiment declares = pushed_mass("noise = \"" + noise + "\"\ninput_noise = \"" + input_noise + "\"\n");
  const codegen::Model with = train(declares, sets.training, sets.validation, {}).model;
  const codegen::Model without = train(pushed_mass(""), sets.training, sets.validation, {}).model;
  return {settled_error(with, sets.validation, noise, input_noise),
          settled_error(without, sets.validation, noise, input_noise)};
}

void expect_gain(const std::string& noise, const std::string& input_noise, double at_most) {
  const Gain found = gain(noise, input_noise);
  EXPECT_LT(found.declared, at_most * found.not_declared)
      << noise << " | " << input_noise << ": " << found.declared << " against " << found.not_declared;
}

TEST(DefectiveSensors, ADeclaredDelayIsCompensated) {
  expect_gain("none+delay:3", "none", 0.5);
}

TEST(DefectiveSensors, DeclaredJitterIsSmoothed) {
  expect_gain("none+jitter:0.5", "none", 0.97);  // little can be gained: D is fixed here; measured: .95
}

TEST(DefectiveSensors, LostSamplesIncreaseTheErrorLessIfTheyAreDeclared) {
  expect_gain("none+missing:0.3:3", "none", 0.9);
}

TEST(DefectiveSensors, NoiseOfAnInputIncreasesTheErrorLessIfItIsDeclared) {
  expect_gain("none", "gaussian:4", 0.9);
}

}  // namespace
}  // namespace nlo::trainer
