// SPDX-License-Identifier: MIT
// A window of measurements as an observer: what training rolls out is what flies, and T* learns from it.
// [observer] saturation, from the experiment to the estimate: training is what it was, and far outside of its domain
// the observer says no more than at the edge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "codegen/base/error.h"
#include "codegen/replay/reference_observer.h"
#include "tests/support/thrown_message.h"
#include "tests/training/testing.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/structures/module.h"
#include "trainer/structures/table.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;

Experiment window_experiment(int samples) {
  const std::string text =
      "name = \"w\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1.0, -1.0]\ninitial_high = [1.0, "
      "1.0]\n[observer]\nstructure = \"window\"\nsamples = " +
      std::to_string(samples) +
      "\n[inverse_map]\nhidden = [8]\nlinear_path = true\n[training]\nsteps = 60\nlearning_rate = 0.01\n"
      "trajectories_per_step = 8\nsamples_per_step = 200\n";
  Experiment experiment = parse_experiment(text, "window.toml");
  experiment.threads = 1;
  return experiment;
}

TEST(Window, RollsOutWhatFlies) {
  // The latent states that training has seen lie in the flown model's domain, gaps and jitter included: its margin is a
  // tenth, so that a window that is filled otherwise falls out of it.
  for (const bool jittered : {false, true}) {
    Dataset data = harmonics({60, 90, 75}, jittered);
    if (jittered) data.trajectories[1].time_s.tail(40).array() += 0.3;  // a gap of seven samples
    const TrainingResult result = train(window_experiment(5), data, data, {});
    ASSERT_EQ(result.model.nz(), 5);
    codegen::ReferenceObserver<double> observer(result.model);
    Eigen::VectorXd lowest = Eigen::VectorXd::Constant(5, 1e9), highest = -lowest;
    for (const Trajectory& run : data.trajectories) {
      const codegen::Run flown = observer.run(run.outputs, {}, run.time_s, data.uniform);
      lowest = lowest.cwiseMin(flown.z.rowwise().minCoeff());
      highest = highest.cwiseMax(flown.z.rowwise().maxCoeff());
    }
    const Eigen::VectorXd range = highest - lowest;
    EXPECT_LT((result.model.latent_min - (lowest - 0.1 * range)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((result.model.latent_max - (highest + 0.1 * range)).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_NEAR(result.validation_rmse, testing::reference_rmse(result.model, data), 1e-3 * result.validation_rmse);
  }
}

TEST(Window, AFirstMeasurementFillsItAndAGapLiesOnTheRamp) {
  const Dataset data = harmonics({40}, false);
  codegen::ReferenceObserver<double> observer(train(window_experiment(4), data, data, {}).model);
  const auto y = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  observer.step(y(0.5));
  EXPECT_EQ(observer.latent(), Eigen::VectorXd::Constant(4, 0.5));
  observer.step(y(0.8), {}, 3.0 * data.sample_period_s);
  EXPECT_LT((observer.latent() - Eigen::Vector4d(0.8, 0.7, 0.6, 0.5)).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(Window, MoreSamplesThanOneTellAVelocity) {
  const Dataset data = harmonics({80, 80, 80}, false);
  const auto error = [&](int samples) { return train(window_experiment(samples), data, data, {}).validation_rmse; };
  EXPECT_LT(error(3), 0.5 * error(1)) << "control: one position has no velocity";
}

TEST(Window, RefusesWhatItHasNoUseFor) {
  const auto message = [](const std::string& line) -> std::string {
    try {
      parse_experiment(
          "name = \"w\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1.0, -1.0]\ninitial_high = "
          "[1.0, 1.0]\n[observer]\nstructure = \"window\"\n" +
              line + "\n",
          "w.toml");
    } catch (const codegen::Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_EQ(message("samples = 4"), "no error");
  EXPECT_EQ(message("eigenvalues = [-1.0]").find("w.toml:9: [observer] eigenvalues has no use"), 0U);
  EXPECT_EQ(message("samples = 0").find("w.toml:9: [observer] samples"), 0U) << message("samples = 0");
}

/// Logs of y = x = `amplitude` sin(t + phase).
Dataset sines(double amplitude) {
  Dataset data;
  data.outputs = {{"y", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.sample_period_s = 0.05;
  for (int r = 0; r < 3; ++r) {
    Trajectory run;
    run.source = "run " + std::to_string(r);
    run.time_s = Eigen::VectorXd::LinSpaced(200, 0.0, 199 * 0.05);
    run.states = amplitude * (run.time_s.array() + 2.0 * r).sin().matrix().transpose();
    run.outputs = run.states;
    run.weight = Eigen::VectorXd::Ones(200);
    data.trajectories.push_back(run);
  }
  return data;
}

std::string saturating_experiment(const std::string& structure, const std::string& saturation) {
  return "name = \"s\"\n[log]\nsample_period_s = 0.05\ntrain_files = [\"a.csv\"]\n[[log.columns]]\nname = \"y\"\nrole "
         "= "
         "\"output\"\n[[log.columns]]\nname = \"x\"\nrole = \"state\"\n[observer]\nstructure = \"" +
         structure + "\"\neigenvalues = [-4.0, -9.0]\nlearn_eigenvalues = false\nstart = \"steady\"\n" + saturation +
         "[inverse_map]\nhidden = [8]\nlinear_path = true\n[training]\nsteps = 60\nsegment_s = 5.0\n";
}

codegen::Model trained(const std::string& saturation) {
  Experiment experiment = parse_experiment(saturating_experiment("kkl", saturation), "s.toml");
  experiment.threads = 1;
  experiment.inverse_map.readout = ReadoutChoice::kNetwork;  // the same T* with and without it
  const Dataset data = sines(1.0);
  return train(experiment, data, data, {}).model;
}

double largest_estimate(const codegen::Model& model, double amplitude) {
  codegen::ReferenceObserver<double> observer(model);
  const Trajectory run = sines(amplitude).trajectories[0];
  return observer.run(run.outputs, {}, run.time_s, true).x_hat.cwiseAbs().maxCoeff();
}

TEST(Saturation, FarOutsideTheEstimateStaysNearWhatTrainingHasSeen) {
  const codegen::Model limited = trained("saturation = 0.5\n"), free = trained("");
  EXPECT_EQ(limited.saturation, 0.5);
  EXPECT_EQ(free.saturation, 0.0);
  EXPECT_EQ(largest_estimate(limited, 1.0), largest_estimate(free, 1.0)) << "training is not touched by it";
  // The map follows y = x, at half a half range outside of +-1 to 1.5, and in a corner of the box a little further.
  EXPECT_LT(largest_estimate(limited, 3.0), 2.3);
  EXPECT_GT(largest_estimate(free, 3.0), 2.8) << "control: a linear path goes on";
}

std::string saturation_refusal(const std::string& structure, const std::string& saturation) {
  return thrown_message([&] { parse_experiment(saturating_experiment(structure, saturation), "s.toml"); });
}

TEST(Saturation, WhatCannotBeIsRefusedByItsKey) {
  using ::testing::HasSubstr;
  EXPECT_THAT(saturation_refusal("kkl", "saturation = -1.0\n"), HasSubstr("[observer] saturation is -1"));
  EXPECT_THAT(saturation_refusal("general", "saturation = 0.5\n"), HasSubstr("saturation"));
}

}  // namespace
}  // namespace nlo::trainer
