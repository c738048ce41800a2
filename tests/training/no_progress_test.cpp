// SPDX-License-Identifier: MIT
#include "trainer/learn/training/no_progress.h"
#include "tests/support/mirrored.h"
#include "trainer/learn/losses/loss_registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/model_file/model_file.h"
#include "tests/training/training_testing.h"
#include "trainer/learn/training/objective.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;
using ::testing::HasSubstr;
using testing::small_experiment;

/// Rows at steps 0, 1, 2, ... with these losses and validation errors.
std::vector<MetricsRow> rows(const std::vector<double>& losses, const std::vector<double>& errors) {
  std::vector<MetricsRow> metrics;
  for (std::size_t i = 0; i < losses.size(); ++i) {
    MetricsRow& row = metrics.emplace_back();
    row.step = static_cast<std::int64_t>(i);
    row.loss = losses[i];
    row.validation_rmse = errors[i];
  }
  return metrics;
}

TEST(NoProgress, IsReportedIfNoStepImprovesOnTheStart) {
  EXPECT_THAT(no_progress(rows({1, .9, .8}, {1.0, 1.0, 1.2})), HasSubstr("none of its 2 steps"));
  EXPECT_EQ(no_progress(rows({1, .9, .8}, {1.0, 0.999, 1.2})), "") << "control: one step did";
  EXPECT_EQ(no_progress(rows({1}, {1.0})), "") << "no step was made yet";
}

TEST(NoProgress, IsReportedIfTheLossGrowsBeyondItsStartAndStays) {
  const std::vector<double> errors = {1, .9, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1};
  EXPECT_THAT(no_progress(rows({1, .9, 2, 3, 4, 5, 5, 5, 5, 5, 5, 5, 5}, errors)), HasSubstr("grew from 1"));
  EXPECT_EQ(no_progress(rows({1, .9, 2, 3, 4, 5, 5, 5, 5, 5, 5, .9, 5}, errors)), "") << "control: the loss returned";
  EXPECT_EQ(no_progress(rows({1, 9}, {1, .9})), "") << "a single draw of samples is not a trend";
}

TrainingResult run(const Experiment& experiment, Dataset training = harmonics(std::vector<int>(10, 60), false, 1)) {
  if (experiment.training.mirror) training = testing::mirrored(training);
  return train(experiment, training, harmonics({50, 40, 30}, false, 2), {});
}

TEST(NoProgress, KeepsTheFirstModelAndNamesALearningRateThatIsTooHigh) {
  Experiment experiment = small_experiment();
  experiment.inverse_map.linear_path = true;  // starts from ridge regression, which large random steps do not improve
  experiment.training.learning_rate = 30.0;
  const TrainingResult result = run(experiment);
  ASSERT_EQ(result.outcome, TrainOutcome::kNoProgress) << result.message;
  EXPECT_THAT(result.message, HasSubstr("learning_rate = 30 may be too high: try 3"));
  EXPECT_THAT(result.message, HasSubstr("No feature leaves its scale"));
  EXPECT_EQ(result.validation_rmse, result.metrics.front().validation_rmse);
  EXPECT_FALSE(codegen::to_json(result.model).empty());
  experiment.training.learning_rate = 1e-3;
  EXPECT_EQ(run(experiment).outcome, TrainOutcome::kFinished) << "control";
}

TEST(NoProgress, IsASuccessIfNoStepImprovesTheClosedFormFit) {
  Experiment experiment = small_experiment();
  experiment.inverse_map.linear_path = true;  // starts from ridge regression
  experiment.training.learning_rate = 1e-30;  // no step changes a float, so none improves the model
  const TrainingResult result = run(experiment);
  EXPECT_EQ(result.outcome, TrainOutcome::kClosedForm) << result.message;
  EXPECT_TRUE(result.succeeded());
  EXPECT_THAT(result.message, HasSubstr("the closed form is best: none of 30 training steps"));
  EXPECT_EQ(result.validation_rmse, result.metrics.front().validation_rmse) << "the ridge regression is the model";

  experiment.inverse_map.linear_path = false;  // starts from random weights
  EXPECT_EQ(run(experiment).outcome, TrainOutcome::kNoProgress)
      << "control: without a linear path there is no closed form";
}

TEST(NoProgress, NamesTheChannelThatIsNotCentredUnderAWrongMirror) {
  Experiment experiment = small_experiment();
  experiment.inverse_map.linear_path = true;
  experiment.training.learning_rate = 30.0;
  experiment.training.mirror = true;
  Dataset shifted = harmonics(std::vector<int>(10, 60), false, 1);
  EXPECT_THAT(run(experiment, shifted).message, ::testing::Not(HasSubstr("is odd"))) << "control: the data are centred";
  for (Trajectory& trajectory : shifted.trajectories) trajectory.states.row(1).array() += 40.0;
  EXPECT_THAT(run(experiment, shifted).message, HasSubstr("the mean of velocity is"));
}

TEST(NoProgress, NamesTheFeatureThatLeavesItsScale) {
  Experiment experiment = small_experiment();
  experiment.observer.clocks_s = {0.3};
  experiment.threads = 1;
  const Dataset dataset = harmonics({60, 60}, false);
  const TrainingData data(dataset);
  ThreadPool pool(1);
  ObserverStructure structure =
      make_structure(experiment, needs_forward_map(experiment.loss), dataset.outputs, dataset.states);
  Objective objective(experiment, structure, data, pool);
  const Rollout& flight = objective.roll_out_flight(initial_dynamics(structure, experiment).data());
  normalise(structure, flight);
  EXPECT_THAT(likely_causes(experiment, {}, structure, dataset, flight), HasSubstr("No feature leaves its scale"));
  structure.features.back().scale = 1e-6F;
  EXPECT_EQ(largest_feature(structure, dataset.outputs, flight).name, "the clock of 0.3 s");
  EXPECT_NEAR(largest_feature(structure, dataset.outputs, flight).reach, 0.5e6, 1.0);
  EXPECT_THAT(likely_causes(experiment, {}, structure, dataset, flight),
              HasSubstr("first: the clock of 0.3 s reaches 5e+05 times its scale"));
}

}  // namespace
}  // namespace nlo::trainer
