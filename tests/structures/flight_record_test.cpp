// SPDX-License-Identifier: MIT
// The record of training data on which exports are tested.
#include "trainer/structures/flight_record.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "codegen/targets/prepared_export.h"
#include "tests/evaluation/van_der_pol_set.h"
#include "tests/training/training_testing.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

codegen::Model trained_on(const Dataset& data, double noise = 0.0) {
  Experiment experiment = testing::small_experiment();
  experiment.training.steps = 2;
  if (noise > 0.0) experiment.training.noise = {NoiseKind::kGaussian, noise};
  return train(experiment, data, data, {}).model;
}

VectorXd flown_output(const codegen::Model& model, const codegen::FlightRun& run) {
  return model.flight.output_step(0) * run.outputs.row(0).cast<double>().transpose();
}

/// Returns the sample at which `run` begins in the first output of a trajectory, or -1.
Index start_in(const VectorXd& run, const Trajectory& trajectory, double tolerance) {
  for (Index start = 0; start + run.size() <= trajectory.samples(); ++start)
    if ((trajectory.outputs.row(0).segment(start, run.size()).transpose() - run).cwiseAbs().maxCoeff() <= tolerance)
      return start;
  return -1;
}

TEST(FlightRecord, HasPiecesOfAllRunsAndHalfOfThemBeginAtTheFirstSample) {
  const Dataset data = test::van_der_pol_set(60, 14.0, 1, 2.0);  // 701 samples per run
  const codegen::Model model = trained_on(data);
  EXPECT_GE(model.flight.samples(), 12000);
  EXPECT_LT(model.flight.samples(), 13000);
  const double half_step = 0.5 * model.flight.output_step(0) + 1e-6;  // plus rounding of floats
  int found = 0, from_the_start = 0;
  Index last_trajectory = 0;
  for (const codegen::FlightRun& run : model.flight.runs) {
    const VectorXd y = flown_output(model, run);
    for (std::size_t r = 0; r < data.trajectories.size(); ++r) {
      const Index start = start_in(y, data.trajectories[r], half_step);
      if (start < 0) continue;
      ++found;
      from_the_start += start == 0;
      last_trajectory = std::max(last_trajectory, static_cast<Index>(r));
      break;
    }
  }
  const auto runs = static_cast<int>(model.flight.runs.size());
  EXPECT_EQ(found, runs);
  EXPECT_NEAR(from_the_start, runs / 2, 1);
  EXPECT_GT(last_trajectory, 50) << "the record is spread over all data";
}

TEST(FlightRecord, HasTheNoiseOfTraining) {
  const Dataset data = test::van_der_pol_set(1, 10.0, 1, 2.0);
  const codegen::Model model = trained_on(data, 0.3);
  ASSERT_EQ(model.flight.runs.size(), 1U);
  const VectorXd off = flown_output(model, model.flight.runs[0]) - data.trajectories[0].outputs.row(0).transpose();
  const double deviation = std::sqrt(off.squaredNorm() / static_cast<double>(off.size()));
  EXPECT_NEAR(deviation, 0.3, 4.0 * 0.3 / std::sqrt(2.0 * 501.0));  // four standard errors
}

TEST(FlightRecord, HasTimesOnlyForIrregularLogs) {
  const Dataset data = testing::harmonics({700, 900}, true);
  const codegen::Model model = trained_on(data);
  EXPECT_EQ(trained_on(testing::harmonics({700}, false)).flight.runs[0].dt.size(), 0);
  EXPECT_EQ(model.flight.samples(), 700 + 900) << "short data are recorded completely";
  const double half_step = 0.5 * model.flight.output_step(0) + 1e-6;
  for (std::size_t i = 0; i < model.flight.runs.size(); ++i) {
    const codegen::FlightRun& run = model.flight.runs[i];
    const Trajectory& trajectory = data.trajectories[i];
    const Index start = start_in(flown_output(model, run), trajectory, half_step);
    ASSERT_GE(start, 0);
    for (Index k = 1; k < run.dt.size(); ++k)
      ASSERT_NEAR(model.flight.dt_step_s * run.dt(k), trajectory.time_s(start + k) - trajectory.time_s(start + k - 1),
                  0.5 * model.flight.dt_step_s);
  }
}

TEST(FlightRecord, HasTheInputsOfADrivenPlantAndZeroWithoutExcitation) {
  Experiment experiment = testing::small_experiment();
  experiment.observer.structure = "driven_kkl";
  experiment.observer.eigenvalues = {-1.0, -1.5, -2.0};
  experiment.observer.pairs = {};
  experiment.observer.learn_eigenvalues = false;
  experiment.forward_map.hidden = {5};
  experiment.loss.weights["map_consistency"] = 1.0;
  experiment.training.steps = 2;
  Dataset data = test::van_der_pol_set(1, 8.0, 1, 2.0);
  data.inputs = {{"u", "", 0.0}};
  data.input_field = {Eigen::MatrixXd::Zero(2, 2), Eigen::Vector2d(0.0, 1.0)};
  const codegen::Model quiet = train(experiment, data, data, {}).model;
  EXPECT_EQ(quiet.flight.runs.at(0).inputs, Eigen::MatrixXi::Zero(1, 401));

  const VectorXd u = (3.0 * data.trajectories[0].time_s.array()).sin();
  data.trajectories[0].inputs = u.transpose();
  const codegen::Model driven = train(experiment, data, data, {}).model;
  const VectorXd flown =
      driven.flight.input_step(0) * driven.flight.runs.at(0).inputs.row(0).cast<double>().transpose();
  EXPECT_LE((flown - u).cwiseAbs().maxCoeff(), 0.5 * driven.flight.input_step(0));
}

TEST(FlightRecord, IsUsedForTheErrorOfAnExport) {
  const codegen::Model model = trained_on(test::van_der_pol_set(40, 12.0, 2, 2.0), 0.1);
  EXPECT_GE(codegen::PreparedExport(model).error().recorded, 10000);
}

}  // namespace
}  // namespace nlo::trainer
