// SPDX-License-Identifier: MIT
#include "trainer/learn/training/train.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "tests/evaluation/van_der_pol_set.h"
#include "tests/training/small_trainings.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

TEST(Train, StoppedBeforeItsFirstStepReturnsTheInitialModel) {
  const std::atomic<bool> stop = true;
  TrainOptions options;
  options.stop = &stop;
  const TrainingResult result = train_here(small_experiment(), options);
  EXPECT_EQ(result.outcome, TrainOutcome::kInterrupted);
  EXPECT_EQ(result.steps_done, 0);
  EXPECT_FALSE(codegen::to_json(result.model).empty());
}

TEST(Train, ADivergedTrainingKeepsTheBestModelAndSaysWhatToTry) {
  struct Variant {
    const char* name;
    std::function<void(TrainingConfig&)> change;
  };
  const std::vector<Variant> variants = {
      {"descent",
       [](TrainingConfig& training) {
         training.optimiser = "gradient_descent";
         training.learning_rate = 1e6;
       }},
      {"Adam",
       [](TrainingConfig& training) {
         training.learning_rate = 1e12;
         training.eigenvalue_learning_rate = 1e-3;
         training.schedule = "constant";
       }},
      // One Adam step moves log|lambda| by the rate: exp(1000) is infinite, and halving the step does not help.
      {"eigenvalues that overflow", [](TrainingConfig& training) { training.eigenvalue_learning_rate = 1000.0; }},
  };
  for (const Variant& variant : variants) {
    SCOPED_TRACE(variant.name);
    Experiment experiment = small_experiment();
    variant.change(experiment.training);
    const ScratchDirectory directory;
    const TrainingResult result = train_here(experiment, writing_to(directory));
    ASSERT_EQ(result.outcome, TrainOutcome::kDiverged);
    EXPECT_LT(result.steps_done, experiment.training.steps);
    EXPECT_THAT(result.message, HasSubstr("diverged"));
    EXPECT_THAT(result.message, HasSubstr("learning_rate"));
    EXPECT_TRUE(std::isfinite(result.validation_rmse));
    EXPECT_LE(result.validation_rmse, result.metrics.front().validation_rmse);
    const std::string json = codegen::to_json(result.model);  // throws unless all of it is finite
    EXPECT_NO_THROW(codegen::parse_model(json, "diverged"));
    EXPECT_TRUE(std::filesystem::exists(directory.path("checkpoint.bin")));
  }
}

TEST(Train, ContinuesFromItsBestModelAfterADivergenceIfGradientsAreClipped) {
  // A learning rate that grows by half in each step makes the training diverge repeatedly. With clipped gradients it
  // returns each time, up to the last step or the limit of returns; without clipping it does not.
  Experiment experiment = small_experiment();
  experiment.training.learning_rate = 0.01;
  experiment.training.schedule = "exponential";
  experiment.training.decay = 1.5;
  experiment.training.validate_every = 1;
  experiment.training.gradient_clip = 1.0;
  const TrainingResult clipped = train_here(experiment);
  EXPECT_GT(clipped.returns, 0);
  EXPECT_LE(clipped.validation_rmse, clipped.metrics.front().validation_rmse);
  experiment.training.gradient_clip = 0.0;
  EXPECT_EQ(train_here(experiment).returns, 0);
}

// Fails if training goes on at the full rate, which made it run away from the same model again and again.
TEST(Train, AfterADivergenceTheLearningRateRisesFromZero) {
  Experiment experiment = small_experiment();
  experiment.training.learning_rate = 1.0;
  experiment.training.schedule = "constant";
  experiment.training.validate_every = 1;
  experiment.training.gradient_clip = 1.0;
  const TrainingResult result = train_here(experiment);
  ASSERT_GT(result.returns, 0) << "control: the rate is too large";
  int zeros = 0;
  for (std::size_t i = 1; i < result.metrics.size(); ++i) {
    const double before = result.metrics[i - 1].learning_rate, rate = result.metrics[i].learning_rate;
    zeros += rate == 0.0 ? 1 : 0;
    if (i > 1 && rate > 0.0 && before < 1.0) {
      EXPECT_NEAR(rate, before + 1.0 / 200.0, 1e-12) << "200 steps to the full rate";
    }
  }
  EXPECT_EQ(zeros, result.returns);
}

TEST(Train, AnErrorThatOnlyTrainingRunsHaveIsNotADivergence) {
  // Segments that begin anywhere have a transient, which validation hardly has. Here noise on their truth represents
  // it, and validation leaves the transient out.
  constexpr double kNoise = 2.0, kFar = 4.0;  // kNoise in m; kFar in validation errors, the limit
  constexpr Eigen::Index kTransient = 25;     // samples: exp(-1.25) of the slowest mode; runs have 30 samples or more
  Dataset training = training_set(), validation = validation_set();
  for (Dataset* set : {&training, &validation})
    for (Trajectory& run : set->trajectories) run.states = run.outputs.row(0).replicate(run.states.rows(), 1);
  std::mt19937_64 engine(1);
  std::normal_distribution<double> noise(0.0, kNoise);
  for (Trajectory& run : training.trajectories)
    run.states = run.states.unaryExpr([&](double x) { return x + noise(engine); });
  for (Trajectory& run : validation.trajectories) run.weight.head(kTransient).setZero();
  Experiment experiment = small_experiment();
  experiment.observer.features = FeatureSet::kLatentAndOutput;  // y is one of the states
  experiment.inverse_map.hidden = {16};
  experiment.training.steps = 2000;
  experiment.training.schedule = "cosine";
  experiment.training.ema = 0.98;
  experiment.training.validate_every = 50;
  experiment.training.gradient_clip = 1.0;
  const TrainingResult result = train(experiment, training, validation, {});
  const MetricsRow &first = result.metrics.front(), &last = result.metrics.back();
  ASSERT_GT(last.train_rmse, kFar * result.validation_rmse * first.train_rmse / first.validation_rmse)
      << "the untrained observer has the same transient";
  EXPECT_EQ(result.returns, 0);
  EXPECT_EQ(result.outcome, TrainOutcome::kFinished) << result.message;
}

TEST(Train, SplitsTheValidationErrorAtTheEndOfTheTransient) {
  const Dataset validation = validation_set();
  const auto split_at = [&](double samples) {
    TrainOptions options;
    options.settled_from_s = samples * validation.sample_period_s;
    return train_here(small_experiment(), options).split;
  };
  constexpr double kSplit = 10.0;  // below the shortest run
  double early = 0.0, late = 0.0;
  for (const Trajectory& run : validation.trajectories)
    for (Eigen::Index k = run.first_estimate; k < run.samples(); ++k)
      (static_cast<double>(k) < kSplit ? early : late) += 1.0;
  const SplitError all = split_at(1e6), split = split_at(kSplit);
  EXPECT_EQ(all.transient, all.settled) << "no run is that long";
  EXPECT_NE(split.transient, split.settled);
  const double squares = early * split.transient * split.transient + late * split.settled * split.settled;
  EXPECT_NEAR(std::sqrt(squares / (early + late)), all.both(), 1e-9 * all.both());  // rounding of a sum
  EXPECT_EQ(train_here(small_experiment()).split.both(), 0.0) << "not requested";
}

TEST(Train, KeepsTheBestModelInsteadOfTheLast) {
  // A training that diverges late: the written model has the lowest validation error on record.
  Experiment experiment = small_experiment();
  experiment.training.learning_rate = 0.01;
  experiment.training.schedule = "exponential";  // growing: the training learns first and then diverges
  experiment.training.decay = 1.3;
  experiment.training.validate_every = 1;
  const TrainingResult result = train_here(experiment);
  double lowest = result.metrics.front().validation_rmse;
  for (const MetricsRow& row : result.metrics) lowest = std::min(lowest, row.validation_rmse);
  EXPECT_EQ(result.validation_rmse, lowest);
  EXPECT_LT(lowest, result.metrics.back().validation_rmse) << "control: the last model is worse";
  EXPECT_NEAR(testing::plain_rmse(result.model, validation_set()), lowest, 1e-5 * lowest);
}

TEST(Train, CallsProgressAfterEachStep) {
  Experiment experiment = small_experiment();
  std::vector<TrainProgress> calls;
  TrainOptions options;
  options.progress = [&](const TrainProgress& progress) { calls.push_back(progress); };
  const TrainingResult result = train_here(experiment, options);
  ASSERT_EQ(calls.size(), static_cast<std::size_t>(experiment.training.steps));
  for (std::size_t i = 0; i < calls.size(); ++i) {
    EXPECT_EQ(calls[i].step, static_cast<long>(i) + 1);
    EXPECT_EQ(calls[i].steps, experiment.training.steps);
    EXPECT_TRUE(std::isfinite(calls[i].loss));
    EXPECT_GE(calls[i].left_s, 0.0);
    ASSERT_EQ(calls[i].eigenvalues.size(), 3U) << "a pair is listed once";
    EXPECT_GT(calls[i].eigenvalues[0].imag(), 0.0);
    EXPECT_LT(calls[i].eigenvalues[2].real(), 0.0);
  }
  EXPECT_EQ(calls.back().rmse, result.metrics.back().validation_rmse);
  EXPECT_EQ(calls.back().left_s, 0.0);
}

TEST(Train, RecordsMetricsAtTheStartEveryFewStepsAndAtTheEnd) {
  const Experiment experiment = small_experiment();
  const ScratchDirectory directory;
  const TrainingResult result = train_here(experiment, writing_to(directory));
  std::vector<std::int64_t> steps;
  for (const MetricsRow& row : result.metrics) steps.push_back(row.step);
  EXPECT_EQ(steps, (std::vector<std::int64_t>{0, 7, 14, 21, 28, 30}));
  EXPECT_EQ(codegen::read_file(directory.path("metrics.csv")), metrics_csv(result.metrics, 1));
}

Eigen::VectorXd eigenvalues_of(const TrainingResult& result) {
  return codegen::linear_latent(result.model)->eigenvalues;
}

TEST(Train, KeepsEigenvaluesThatAreNotLearned) {
  Experiment experiment = small_experiment();
  experiment.training.eigenvalue_learning_rate = 0.1;
  const Eigen::Vector4d initial(-2.0, 3.0, -1.0, -4.0);
  constexpr double kLogarithmInFloat = 1e-6;  // eigenvalues are exponentials of float32 parameters
  EXPECT_GT((eigenvalues_of(train_here(experiment)) - initial).norm(), 0.01) << "control: learned";
  experiment.observer.learn_eigenvalues = false;
  EXPECT_LT((eigenvalues_of(train_here(experiment)) - initial).norm(), kLogarithmInFloat);
}

TEST(Train, RefusesDataThatCannotBeTrainedOn) {
  const Experiment experiment = small_experiment();
  Dataset none = training_set();
  none.trajectories.clear();
  EXPECT_THAT(error_of(experiment, none, validation_set()), HasSubstr("training set holds no trajectories"));
  EXPECT_THAT(error_of(experiment, training_set(), none), HasSubstr("validation set holds no trajectories"));
  const Dataset short_runs = harmonics({40, 1}, false);
  EXPECT_THAT(error_of(experiment, short_runs, validation_set()), HasSubstr("simulation 1: fewer than two samples"));
  EXPECT_THAT(error_of(experiment, training_set(), short_runs), HasSubstr("fewer than two samples"));
  Dataset all_masked = training_set();
  for (Trajectory& run : all_masked.trajectories) run.weight.setZero();
  EXPECT_THAT(error_of(experiment, all_masked, validation_set()), HasSubstr("masked"));
  EXPECT_THAT(error_of(experiment, training_set(), all_masked), HasSubstr("masked"));
  Experiment blind = experiment;
  blind.observer.eigenvalues.clear();
  blind.observer.pairs.clear();
  EXPECT_THAT(error_of(blind, training_set(), validation_set()), HasSubstr("eigenvalues"));
}

TEST(Train, RefusesAnInitialErrorThatIsNotFinite) {
  Experiment unstable = small_experiment();
  unstable.observer.hold = Hold::kRk4;
  unstable.observer.eigenvalues = {-200.0};  // too fast: 10 per sample period
  EXPECT_THAT(error_of(unstable, harmonics({400, 400}, false), validation_set()), HasSubstr("first_order"));
  Dataset broken = validation_set();
  broken.trajectories[1].states(0, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error_of(small_experiment(), training_set(), broken), HasSubstr("not finite"));
}

TEST(Train, AStepWithOnlyMaskedSamplesIsNotADivergence) {
  // One sample in a hundred is unmasked, and a step draws four: most steps have no data.
  Experiment experiment = small_experiment();
  experiment.training.trajectories_per_step = 4;
  experiment.training.samples_per_step = 4;
  Dataset sparse = harmonics(std::vector<int>(8, 100), false);
  for (Trajectory& run : sparse.trajectories) {
    run.weight.setZero();
    run.weight(50) = 1.0;
  }
  EXPECT_NE(train(experiment, sparse, validation_set(), {}).outcome, TrainOutcome::kDiverged);
}

TEST(Train, SegmentLengthsOfJitteredLogsFollowTheNominalPeriod) {
  // A first step that is ten times as long as the others must not determine the length of a segment of one second.
  Experiment experiment = small_experiment();
  experiment.training.segment_s = 1.0;
  Dataset even = harmonics(std::vector<int>(6, 100), true);
  Dataset late = even;
  late.trajectories[0].time_s.tail(99).array() += 9.0 * even.sample_period_s;
  const auto first_loss = [&](const Dataset& data) {
    std::vector<double> losses;
    TrainOptions options;
    options.progress = [&](const TrainProgress& progress) { losses.push_back(progress.loss); };
    (void)train(experiment, data, validation_set(), options);
    return losses.front();
  };
  // Segments and samples are equal; only the samples after the gap in run 0 differ slightly. Segments of a tenth of the
  // length would change the loss much more, because most of their samples lie in the transient from z = 0.
  EXPECT_NEAR(first_loss(late), first_loss(even), 0.05 * first_loss(even));
}

TEST(Train, AShortVanDerPolRunLowersTheValidationErrorFarBelowItsStart) {
  Experiment experiment = small_experiment();
  experiment.observer.pairs = {};
  experiment.observer.eigenvalues = {-1.0, -2.0, -4.0};
  experiment.inverse_map.hidden = {20, 20};
  experiment.training.steps = 300;
  experiment.training.trajectories_per_step = 16;
  experiment.training.samples_per_step = 1024;
  experiment.training.noise = {NoiseKind::kGaussian, 0.05};
  experiment.training.validate_every = 50;
  const TrainingResult result =
      train(experiment, test::van_der_pol_set(20, 15.0, 1, 2.0), test::van_der_pol_set(4, 15.0, 2, 2.0), {});
  EXPECT_EQ(result.outcome, TrainOutcome::kFinished);
  // The remaining error is the transient from z = 0, which no map of z can remove.
  EXPECT_LT(result.validation_rmse, 0.3 * result.metrics.front().validation_rmse);
  EXPECT_LT(testing::plain_rmse(result.model, test::van_der_pol_set(4, 15.0, 3, 2.0)), 0.5)
      << "on unseen noise-free runs, including the transient from z = 0";
}

}  // namespace
}  // namespace nlo::trainer
