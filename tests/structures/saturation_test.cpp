// SPDX-License-Identifier: MIT
// [observer] saturation, from the experiment to the estimate: training is what it was, and far outside of its domain
// the observer says no more than at the edge.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "codegen/replay/reference_observer.h"
#include "tests/support/thrown_message.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/structures/module.h"
#include "trainer/structures/table.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
namespace {

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
