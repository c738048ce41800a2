// SPDX-License-Identifier: MIT
// Training with sensors that may fail: roll-outs equal flight, and one model works without any one of them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "codegen/replay/reference_observer.h"
#include "tests/support/mirrored.h"
#include "tests/support/thrown_message.h"
#include "tests/training/training_testing.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/train.h"
#include "trainer/rollout/sampling.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/structure_table.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

/// x is the sum of two tones; one sensor measures it exactly, the other half of it.
Dataset two_sensors(unsigned seed, bool jittered = false) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  Dataset data;
  data.outputs = {{"good", "", 0.0}, {"poor", "", 0.0}};
  data.states = {{"x", "", 0.0}};
  data.sample_period_s = 0.05;
  data.uniform = !jittered;
  for (int r = 0; r < 6; ++r) {
    Trajectory run;
    run.source = "run " + std::to_string(r);
    run.time_s.resize(200);
    run.outputs.resize(2, 200);
    run.states.resize(1, 200);
    run.weight = Eigen::VectorXd::Ones(200);
    const double phase = 6.0 * uniform(random), other = 6.0 * uniform(random);
    for (int k = 0; k < 200; ++k) {
      run.time_s(k) = k == 0 ? 0.0 : run.time_s(k - 1) + 0.05 * (jittered ? 0.6 + 0.8 * uniform(random) : 1.0);
      const double slow = std::sin(run.time_s(k) + phase), fast = 0.4 * std::sin(3.1 * run.time_s(k) + other);
      run.states(0, k) = 5.0 + slow + fast;
      run.outputs.col(k) << 5.0 + slow + fast, slow;
    }
    data.trajectories.push_back(run);
  }
  return data;
}

std::string experiment_text(const std::string& observer, const std::string& training) {
  return "name = \"f\"\n[log]\nsample_period_s = 0.05\ntrain_files = [\"a.csv\"]\n[[log.columns]]\nname = \"good\"\n"
         "role = \"output\"\n[[log.columns]]\nname = \"poor\"\nrole = \"output\"\n[[log.columns]]\nname = \"x\"\n"
         "role = \"state\"\n[observer]\neigenvalues = [-4.0]\noutput_injection = \"unit_gain\"\nstart = \"steady\"\n"
         "features = \"latent_and_output\"\nlearn_eigenvalues = false\n" +
         observer +
         "[inverse_map]\nhidden = [16]\nlinear_path = true\n[training]\nsteps = 600\nlearning_rate = 0.01\nsegment_s = "
         "5.0\n"
         "trajectories_per_step = 16\nsamples_per_step = 800\n" +
         training;
}

Experiment failing_experiment(const std::string& observer, const std::string& training = "") {
  Experiment experiment = parse_experiment(experiment_text(observer, training), "f.toml");
  experiment.threads = 1;
  return experiment;
}

double error_of(const codegen::Model& model, Dataset data, bool without_good) {
  for (Trajectory& run : data.trajectories)
    if (without_good) run.outputs.row(0).setConstant(std::numeric_limits<double>::quiet_NaN());
  return testing::reference_rmse(model, data);
}

TEST(FailingSensors, OneModelWorksWithAndWithoutASensor) {
  const Dataset data = two_sensors(1), unseen = two_sensors(2);
  const codegen::Model ready =
      train(failing_experiment("may_fail = [\"good\"]\nstaleness_s = 0.3\n"), data, data, {}).model;
  EXPECT_EQ(ready.failures.outputs, std::vector<int>{0});
  EXPECT_NEAR(ready.failures.rest(0), 5.0, 0.1);
  EXPECT_LT(error_of(ready, unseen, false), 0.1);
  EXPECT_LT(error_of(ready, unseen, true), 0.4) << "the poor sensor measures all but .28 of it";
  const codegen::Model fragile = train(failing_experiment(""), data, data, {}).model;
  EXPECT_GT(error_of(fragile, unseen, true), 2.0) << "control: a model without may_fail never starts";
}

TEST(FailingSensors, AnEmptyCellIsAnOutageOnlyIfTheSensorMayFail) {
  Dataset holey = two_sensors(3);
  for (Trajectory& run : holey.trajectories) {
    run.missing.setConstant(2, run.samples(), false);
    run.missing.middleCols(60, 30).setConstant(true);
    for (int k = 60; k < 90; ++k) run.outputs.col(k) = run.outputs.col(59);
  }
  const Experiment experiment = failing_experiment("may_fail = [\"good\"]\nstaleness_s = 0.3\n");
  const codegen::SensorFailures failures = structure_of(experiment.observer).failures(experiment, holey);
  const TrainingData training(holey, failures);
  const ObserverStructure structure = make_structure(experiment, false, holey.outputs, holey.states, {}, 1);
  ThreadPool pool(1);
  const auto dynamics = structure.module->latent_dynamics(experiment, structure, training.steps_s, 1);
  dynamics->prepare(initial_dynamics(structure, experiment).data());
  Rollout rollout(training);
  rollout.run(whole_runs(training), *dynamics, {}, 1, Purpose::kValidationNoise, 0, pool);
  const SegmentGroup& group = rollout.groups().front();
  const double keep = std::exp(-0.05 / 0.3);
  for (int k = 0; k < 200; ++k) {
    const double missed = k >= 60 ? std::min(k, 89) - 59 : 0;
    const double stale = (1.0 - std::pow(keep, missed)) * (k >= 90 ? std::pow(keep, k - 89) : 1.0);
    EXPECT_NEAR(group.readings[group.at(2, k)], stale, 1e-5) << k;
    EXPECT_NEAR(group.readings[group.at(1, k)], holey.trajectories[0].outputs(1, k), 1e-6) << k;
  }
  EXPECT_LT(group.readings[group.at(2, 59)], 1e-6F);  // control
}

/// Compares the first 200 samples of a run in flight with lane `r` of a roll-out: three readings and z. Training rounds
/// steps to 1/16384 of a period.
void expect_flown_as_rolled_out(const SegmentGroup& group, std::size_t r, const codegen::Run& flown) {
  for (int k = 0; k < 200; ++k) {
    for (int j = 0; j < 3; ++j)
      ASSERT_NEAR(group.readings[group.at(j, k) + r], flown.y(j, k), 1e-4) << r << " " << k << " " << j;
    for (int row = 0; row < 2; ++row)
      ASSERT_NEAR(group.latent[group.at(row, k) + r], flown.z(row, k), 1e-3) << r << " " << k << " " << row;
  }
}

TEST(FailingSensors, RollOutsEqualFlight) {
  for (const bool jittered : {false, true}) {
    const Dataset data = two_sensors(3, jittered);
    Experiment experiment = failing_experiment("may_fail = [\"good\"]\nstaleness_s = 0.3\n");
    const codegen::SensorFailures failures = structure_of(experiment.observer).failures(experiment, data);
    const TrainingData training(data, failures);
    ASSERT_EQ(training.nr, 3);
    const ObserverStructure structure = make_structure(experiment, false, data.outputs, data.states, {}, 1);
    ThreadPool pool(1);
    const auto dynamics = structure.module->latent_dynamics(experiment, structure, training.steps_s, 1);
    dynamics->prepare(initial_dynamics(structure, experiment).data());
    std::vector<Segment> segments = whole_runs(training);
    for (Segment& segment : segments) segment.outages = {{20 + 5 * segment.run, 110}};
    Rollout rollout(training);
    rollout.run(segments, *dynamics, {}, 1, Purpose::kValidationNoise, 0, pool);

    const codegen::Model model =
        train(failing_experiment("may_fail = [\"good\"]\nstaleness_s = 0.3\n", "dropout = 0.0\n"), data, data, {})
            .model;
    codegen::ReferenceObserver<double> observer(model);
    const SegmentGroup& group = rollout.groups().front();
    for (std::size_t r = 0; r < data.trajectories.size(); ++r) {
      Eigen::MatrixXd outputs = data.trajectories[r].outputs;
      for (int k = segments[r].outages[0].from; k < 110; ++k) outputs(0, k) = std::numeric_limits<double>::quiet_NaN();
      const codegen::Run flown = observer.run(outputs, {}, data.trajectories[r].time_s, data.uniform);
      expect_flown_as_rolled_out(group, r, flown);
    }
  }
}

TEST(FailingSensors, RollOutsOfSlowSensorsEqualFlight) {
  constexpr int kEvery = 8;  // samples; it counts as missing from the twelfth on
  Dataset data = two_sensors(3);
  data.outputs[0].period_s = kEvery * data.sample_period_s;
  for (Trajectory& run : data.trajectories) {
    run.missing.setConstant(2, run.samples(), false);
    for (int k = 0; k < run.samples(); ++k)
      if (k % kEvery != 0) {
        run.missing(0, k) = true;
        run.outputs(0, k) = run.outputs(0, k - 1);
      }
  }
  Experiment experiment = failing_experiment("may_fail = [\"good\"]\nstaleness_s = 0.3\n");
  const codegen::SensorFailures failures = structure_of(experiment.observer).failures(experiment, data);
  const TrainingData training(data, failures);
  EXPECT_EQ(training.not_due, std::vector<int>{kEvery - 1});
  const ObserverStructure structure = make_structure(experiment, false, data.outputs, data.states, {}, 1);
  ThreadPool pool(1);
  const auto dynamics = structure.module->latent_dynamics(experiment, structure, training.steps_s, 1);
  dynamics->prepare(initial_dynamics(structure, experiment).data());
  std::vector<Segment> segments = whole_runs(training);
  for (Segment& segment : segments) segment.outages = {{20 + 5 * segment.run, 110}};
  segments.push_back({.run = 0, .start = 5, .length = 100});  // begins between two samples of the slow sensor
  Rollout rollout(training);
  rollout.run(segments, *dynamics, {}, 1, Purpose::kValidationNoise, 0, pool);

  const codegen::Model model =
      train(failing_experiment("may_fail = [\"good\"]\nstaleness_s = 0.3\n", "dropout = 0.0\n"), data, data, {}).model;
  EXPECT_EQ(model.outputs[0].period_s, kEvery * data.sample_period_s);
  codegen::ReferenceObserver<double> observer(model);
  const SegmentGroup& group = rollout.groups().front();
  double stalest = 0.0;
  for (std::size_t r = 0; r < data.trajectories.size(); ++r) {
    Eigen::MatrixXd outputs = data.trajectories[r].measured();
    for (int k = segments[r].outages[0].from; k < 110; ++k) outputs(0, k) = std::numeric_limits<double>::quiet_NaN();
    const codegen::Run flown = observer.run(outputs, {}, data.trajectories[r].time_s, data.uniform);
    expect_flown_as_rolled_out(group, r, flown);
    stalest = std::max(stalest, flown.y.row(2).head(200).maxCoeff());
  }
  EXPECT_GT(stalest, 0.9) << "control: it is missing for a long time";
  for (int k = 0; k < 100; ++k) {
    ASSERT_NEAR(group.readings[group.at(0, k) + 6], data.trajectories[0].outputs(0, 5 + k), 1e-5) << k;
    ASSERT_EQ(group.readings[group.at(2, k) + 6], 0.0F) << k << ": no reading is missing";
  }
}

TEST(FailingSensors, AreMissingInTheDeclaredShareOfTheSegments) {
  const Dataset data = two_sensors(1);
  Experiment experiment = failing_experiment("may_fail = [\"good\"]\n");
  experiment.training.dropout = 0.4;
  const TrainingData training(data, structure_of(experiment.observer).failures(experiment, data));
  int missing = 0, throughout = 0, all = 0;
  for (long step = 0; step < 200; ++step)
    for (const Segment& segment : draw_segments(experiment, training, step)) {
      ASSERT_EQ(segment.outages.size(), 1u);
      const Outage outage = segment.outages[0];
      ASSERT_TRUE(outage.from >= 0 && outage.from <= outage.to && outage.to <= segment.length);
      ++all;
      missing += outage.to > outage.from ? 1 : 0;
      throughout += outage.to - outage.from == segment.length ? 1 : 0;
    }
  // 3,200 draws: three standard deviations are .026.
  EXPECT_NEAR(static_cast<double>(missing) / all, 0.4, 0.03);
  EXPECT_NEAR(static_cast<double>(throughout) / all, 0.2, 0.03);
}

TEST(FailingSensors, RestAtZeroIfTheyAreMirrored) {
  const Experiment experiment = failing_experiment("may_fail = [\"good\"]\n");
  const auto rest = [&](const Dataset& data) {
    return structure_of(experiment.observer).failures(experiment, data).rest(0);
  };
  EXPECT_EQ(rest(testing::mirrored(two_sensors(1))), 0.0);
  EXPECT_NE(rest(two_sensors(1)), 0.0) << "control";
}

std::string refusal(const std::string& observer) {
  return thrown_message([&] { parse_experiment(experiment_text(observer, ""), "f.toml"); });
}

TEST(FailingSensors, RefusesImpossibleSettingsAndNamesTheRemedy) {
  using ::testing::HasSubstr;
  EXPECT_THAT(refusal("may_fail = [\"best\"]\n"), HasSubstr("which is not an output; the outputs are: good, poor"));
  EXPECT_THAT(refusal("may_fail = [\"good\", \"good\"]\n"), HasSubstr("twice; remove one"));
  EXPECT_THAT(refusal("may_fail = [\"good\", \"poor\"]\n"), HasSubstr("remove one"));
  EXPECT_NO_THROW(failing_experiment("may_fail = [\"good\", \"poor\"]\n", "dropout = 0.0\n"))
      << "control: samples that are lost now and then";
  EXPECT_THAT(refusal("staleness_s = 0.0\n"), HasSubstr("staleness_s"));
}

}  // namespace
}  // namespace nlo::trainer
