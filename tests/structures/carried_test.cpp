// SPDX-License-Identifier: MIT
// Training of carried vectors: roll-outs equal flight, gradients are right, least squares finds the weights, and an
// estimate turns with the sensor.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <string>

#include "codegen/model_file/model_file.h"
#include "codegen/replay/reference_observer.h"
#include "tests/support/thrown_message.h"
#include "tests/training/training_testing.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/carried_latent.h"

namespace nlo::trainer {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using ::testing::HasSubstr;
using testing::reference_rmse;

std::string text_of(const std::string& observer, const std::string& map = "readout = \"network\"\n") {
  std::string text = "name = \"down\"\n[log]\nsample_period_s = 0.02\ntrain_files = [\"a.csv\"]\n";
  for (const auto& [role, unit, names] :
       {std::tuple{"output", "m/s^2", "abc"}, {"input", "rad/s", "uvw"}, {"state", "", "xyz"}})
    for (int i = 0; i < 3; ++i)
      text += std::string("[[log.columns]]\nname = \"") + names[i] + "\"\nrole = \"" + role + "\"\nunit = \"" + unit +
              "\"\n";
  return text + "[observer]\nstructure = \"carried\"\neigenvalues = [-0.5, -2.0]\noutput_injection = \"unit_gain\"\n" +
         "start = \"steady\"\n" + observer + "[inverse_map]\nhidden = []\nlinear_path = true\n" + map;
}

Experiment experiment_of(const std::string& observer, const std::string& training) {
  Experiment experiment = parse_experiment(text_of(observer) + "[training]\n" + training, "down.toml");
  experiment.threads = 1;
  return experiment;
}

std::string refused(const std::string& text) {
  return thrown_message([&] { parse_experiment(text, "down.toml"); });
}

/// A sensor that turns at random and is shaken: the vertical in its axes, its measurement of the vertical, and its
/// rate. `axes`: its mounting.
Dataset turned_sensor(unsigned seed, bool jittered, const Matrix3d& axes = Matrix3d::Identity()) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const auto draw = [&](double size) {
    return Vector3d(size * normal(random), size * normal(random), size * normal(random));
  };
  Dataset data;
  for (const char* name : {"a", "b", "c"}) data.outputs.push_back({name, "m/s^2", 0.0});
  for (const char* name : {"u", "v", "w"}) data.inputs.push_back({name, "rad/s", 0.0});
  for (const char* name : {"x", "y", "z"}) data.states.push_back({name, "", 0.0});
  data.reads_inputs = true;
  data.sample_period_s = 0.02;
  data.uniform = !jittered;
  for (int r = 0; r < 5; ++r) {
    constexpr Eigen::Index kSamples = 700;
    Trajectory run;
    run.source = "simulation " + std::to_string(r);
    run.time_s = Eigen::VectorXd::Zero(kSamples);
    run.outputs.resize(3, kSamples);
    run.states.resize(3, kSamples);
    run.inputs.resize(3, kSamples);
    run.weight = Eigen::VectorXd::Ones(kSamples);
    Vector3d up = draw(1.0).normalized(), rate = draw(1.0), push = Vector3d::Zero();
    for (Eigen::Index k = 0; k < kSamples; ++k) {
      double step_s = data.sample_period_s;
      if (k > 0 && jittered) step_s *= 1.0 + 0.3 * std::sin(static_cast<double>(k));
      rate += draw(0.1) - 0.01 * rate;
      push += 0.3 * (draw(2.0) - push);
      if (k > 0) {
        run.time_s(k) = run.time_s(k - 1) + step_s;
        up = Eigen::AngleAxisd(-rate.norm() * step_s, rate.normalized()) * up;
      }
      run.states.col(k) = axes * up;
      run.inputs.col(k) = axes * (rate + draw(0.01));
      run.outputs.col(k) = axes * (9.81 * up + push);
    }
    data.trajectories.push_back(run);
  }
  return data;
}

TEST(Carried, TrainingEqualsFlight) {
  // The validation error comes from the roll-out of the trainer, in float.
  for (const bool jittered : {false, true})
    for (const char* hold : {"zero_order", "first_order"}) {
      const Dataset data = turned_sensor(1, jittered);
      const std::string observer = std::string("features = \"latent_and_output\"\ninput_hold = \"") + hold + "\"\n";
      const TrainingResult result = train(experiment_of(observer, "steps = 0\n"), data, data, {});
      ASSERT_EQ(result.outcome, TrainOutcome::kFinished) << result.message;
      ASSERT_EQ(result.model.nz(), 6);
      EXPECT_NEAR(result.validation_rmse, reference_rmse(result.model, data), 1e-3 * result.validation_rmse)
          << hold << jittered;
    }
}

TEST(Carried, LeastSquaresEstimateStatesDespiteShaking) {
  const Dataset data = turned_sensor(2, false), unseen = turned_sensor(3, false);
  const codegen::Model model = train(experiment_of("unit_length = true\n", "steps = 0\n"), data, data, {}).model;
  double accelerometer = 0.0, samples = 0.0;
  for (const Trajectory& run : unseen.trajectories)
    for (Eigen::Index k = 0; k < run.samples(); ++k, samples += 1.0)
      accelerometer += (run.outputs.col(k).normalized() - run.states.col(k)).squaredNorm();
  EXPECT_LT(reference_rmse(model, unseen), 0.3 * std::sqrt(accelerometer / samples));
  codegen::ReferenceObserver<double> observer(model);
  const Trajectory& run = unseen.trajectories.front();
  const Eigen::MatrixXd x_hat = observer.run(run.outputs, run.inputs, run.time_s, true).x_hat;
  EXPECT_LT((x_hat.colwise().norm().array() - 1.0).abs().maxCoeff(), 1e-12);
}

TEST(Carried, TrainsTheSameObserverAndDomainForAnyMountingOfTheSensor) {
  const Matrix3d axes = Eigen::AngleAxisd(2.2, Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const Dataset data = turned_sensor(4, false), mounted = turned_sensor(4, false, axes);
  const Experiment experiment = experiment_of("", "steps = 0\n");
  const codegen::Model model = train(experiment, data, data, {}).model;
  const codegen::Model other = train(experiment, mounted, mounted, {}).model;
  constexpr double kFloat = 1e-4;  // error of roll-outs in float, and of a ridge regression on them
  EXPECT_NEAR(reference_rmse(model, mounted), reference_rmse(model, data), 1e-9) << "equal except for rounding";
  EXPECT_NEAR(reference_rmse(other, data), reference_rmse(model, data), kFloat * reference_rmse(model, data));
  for (int r = 0; r < model.nz(); ++r)
    EXPECT_EQ(model.latent_max(r), model.latent_max(r % 2)) << "one range for all axes";
}

TEST(Carried, EstimatesTurnWithTheReadings) {
  // For any weights, the estimates of turned readings are the turned estimates.
  const Matrix3d axes = Eigen::AngleAxisd(2.2, Vector3d(1.0, -2.0, 0.5).normalized()).toRotationMatrix();
  const Dataset data = turned_sensor(6, false);
  const codegen::Model model = train(experiment_of("", "steps = 0\n"), data, data, {}).model;
  codegen::ReferenceObserver<double> observer(model), turned(model);
  const Trajectory& run = data.trajectories.front();
  const Eigen::MatrixXd x_hat = observer.run(run.outputs, run.inputs, run.time_s, true).x_hat;
  const Eigen::MatrixXd image = turned.run(axes * run.outputs, axes * run.inputs, run.time_s, true).x_hat;
  EXPECT_LT((image - axes * x_hat).cwiseAbs().maxCoeff(), 1e-9) << "equal except for rounding";
}

TEST(Carried, LearnsEigenvaluesAndTheModelReadsBack) {
  const Dataset data = turned_sensor(5, false);
  Experiment experiment = experiment_of(
      "", "steps = 0\nlearning_rate = 1e-2\ntrajectories_per_step = 5\nsamples_per_step = 2000\nvalidate_every = 20\n");
  experiment.observer.eigenvalues = {-5.0, -20.0};  // too fast: they pass the shaking on
  const TrainingResult before = train(experiment, data, data, {});
  experiment.training.steps = 200;
  const TrainingResult after = train(experiment, data, data, {});
  EXPECT_LT(after.validation_rmse, 0.7 * before.validation_rmse);
  const std::string text = codegen::to_json(after.model);
  EXPECT_EQ(codegen::to_json(codegen::parse_model(text, "model.json")), text);
}

TEST(CarriedLatent, GradientAgreesWithDifferences) {
  constexpr int kLength = 40, kModes = 2;
  LatentShape shape;
  shape.injection = Injection::kUnitGain;
  shape.starts_steady = true;
  std::vector<double> eigenvalues;
  for (int j = 0; j < 3; ++j)
    for (const double lambda : {-1.0, -6.0}) {
      shape.modes.push_back({.pair = false, .row = shape.rows++, .reading = j});
      eigenvalues.push_back(lambda);
    }
  shape.learned = shape.rows;
  const std::vector<double> steps = {0.05};
  CarriedLatent latent(shape, 3, eigenvalues, steps, false);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(-1.0F, 1.0F);
  SegmentGroup group;
  group.length = kLength;
  group.lanes = kGroup;
  group.readings.resize(6 * kLength * kGroup);
  for (float& y : group.readings) y = 3.0F * uniform(random);
  group.latent.resize(static_cast<std::size_t>(3 * kModes * kLength * kGroup));
  std::vector<float> cotangent(group.latent.size());
  for (float& g : cotangent) g = uniform(random);
  const std::vector<float> parameters = parameters_from_eigenvalues(shape, eigenvalues.data());
  const auto loss = [&](const std::vector<float>& at) {
    latent.prepare(at.data());
    latent.forward(group, 0);
    double sum = 0.0;
    for (std::size_t i = 0; i < cotangent.size(); ++i)
      sum += static_cast<double>(group.latent[i]) * static_cast<double>(cotangent[i]);
    return sum;
  };
  loss(parameters);
  group.cotangent = cotangent;
  latent.backward(group, 0);
  constexpr float kStep = 0.02F;
  constexpr double kTolerance = 0.02;  // sums over 80 ms in float; differences are of second order
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    std::vector<float> up = parameters, down = parameters;
    up[i] += kStep;
    down[i] -= kStep;
    const double difference = (loss(up) - loss(down)) / (2.0 * static_cast<double>(kStep));
    EXPECT_GT(std::abs(difference), 10.0 * kTolerance) << "control " << i;
    EXPECT_NEAR(group.gradient[i], difference, kTolerance * (1.0 + std::abs(difference))) << i;
  }
}

std::string without(std::string text, const std::string& what, const std::string& instead = "") {
  return text.replace(text.find(what), what.size(), instead);
}

TEST(Carried, RefusesChannelsThatAreNotVectorsAndNamesTheRemedy) {
  EXPECT_EQ(refused(text_of("")), "no error");
  EXPECT_THAT(refused(without(text_of(""), "[[log.columns]]\nname = \"c\"\nrole = \"output\"\nunit = \"m/s^2\"\n")),
              HasSubstr("there are 2 outputs"));
  EXPECT_THAT(refused(without(text_of(""), "[[log.columns]]\nname = \"y\"\nrole = \"state\"\nunit = \"\"\n")),
              HasSubstr("there are 2 states"));
  EXPECT_THAT(refused(without(text_of(""), "name = \"w\"\nrole = \"input\"", "name = \"w\"\nrole = \"ignored\"")),
              HasSubstr("there are 2 inputs: give the gyroscope's columns role"));
  EXPECT_THAT(refused(without(text_of(""), "unit = \"rad/s\"", "unit = \"deg/s\"")),
              HasSubstr("input u has the unit \"deg/s\""));
  EXPECT_THAT(refused(text_of("", "")), HasSubstr("readout = \"network\""));
  EXPECT_THAT(refused(without(text_of(""), "hidden = []", "hidden = [8]")), HasSubstr("hidden = []"));
  EXPECT_THAT(refused(text_of("pairs = [[-1.0, 2.0]]\n")), HasSubstr("observer.pairs has no effect"));
  EXPECT_THAT(refused(text_of("features = \"latent_minus_output\"\n")), HasSubstr("latent_and_output"));
}

}  // namespace
}  // namespace nlo::trainer
