// SPDX-License-Identifier: MIT
#include "trainer/training/train.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <limits>

#include "codegen/base/error.h"
#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "tests/training/testing.h"
#include "trainer/losses/registry.h"
#include "trainer/structures/structure.h"
#include "trainer/training/checkpoint.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;
using ::testing::HasSubstr;
using testing::ScratchDirectory;
using testing::small_experiment;

Dataset training_set() {
  return harmonics({40, 60, 33, 50, 28, 60, 44, 35, 60, 40}, false, 1);
}
Dataset validation_set() {
  return harmonics({50, 40, 30}, false, 2);
}

/// All that a step can be made of: noise, segments, pairs, averages, decay, a linear path.
Experiment full_experiment() {
  Experiment experiment = small_experiment();
  experiment.inverse_map.hidden = {17, 9};
  experiment.inverse_map.linear_path = true;
  experiment.training.noise = {NoiseKind::kGaussian, 0.2};
  experiment.training.noise_level_max = 1.5;
  experiment.training.segment_s = 1.0;
  experiment.training.ema = 0.9;
  experiment.training.weight_decay = 0.01;
  experiment.training.trajectories_per_step = 40;
  experiment.training.samples_per_step = 2000;
  return experiment;
}

TrainingResult train_here(const Experiment& experiment, const TrainOptions& options = {}) {
  return train(experiment, training_set(), validation_set(), options);
}

TrainOptions writing_to(const ScratchDirectory& directory, bool resume = false) {
  TrainOptions options;
  options.directory = directory.path();
  options.resume = resume;
  return options;
}

/// Stops the run after `steps` of this session.
TrainingResult train_for(const Experiment& experiment, const std::string& directory, bool resume, int steps) {
  std::atomic<bool> stop = false;
  TrainOptions options;
  options.directory = directory;
  options.resume = resume;
  options.stop = &stop;
  int done = 0;
  options.progress = [&](const TrainProgress&) { stop = ++done >= steps; };
  return train_here(experiment, options);
}

std::string error_of(const Experiment& experiment, const Dataset& training, const Dataset& validation,
                     const TrainOptions& options = {}) {
  try {
    (void)train(experiment, training, validation, options);
  } catch (const codegen::Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Train, GivesTheSameBytesForAnyNumberOfThreads) {
  for (const auto mode : {TrainingMode::kRandomSamples, TrainingMode::kFullBatch}) {
    Experiment experiment = full_experiment();
    experiment.training.mode = mode;
    const TrainingResult one = train_here(experiment);
    const std::string bytes = codegen::to_json(one.model);
    for (const int threads : {2, 3}) {
      experiment.threads = threads;
      for (int repeat = 0; repeat < 3; ++repeat) {
        const TrainingResult result = train_here(experiment);
        EXPECT_EQ(codegen::to_json(result.model), bytes) << to_name(mode) << ", " << threads << " threads";
        EXPECT_EQ(result.metrics.back().loss, one.metrics.back().loss);
      }
    }
    experiment.seed += 1;
    EXPECT_NE(codegen::to_json(train_here(experiment).model), bytes) << "control: another seed";
  }
}

TEST(Train, ResumedRunsGiveTheBytesOfAnUninterruptedOne) {
  for (const char* optimiser : {"adam", "gradient_descent"}) {
    for (const double ema : {0.0, 0.9}) {
      Experiment experiment = full_experiment();
      experiment.training.optimiser = optimiser;
      experiment.training.ema = ema;
      if (experiment.training.optimiser != "adam") experiment.training.learning_rate = 1e-3;
      const TrainingResult whole = train_here(experiment);
      ASSERT_NE(whole.outcome, TrainOutcome::kDiverged);
      const ScratchDirectory directory;
      const TrainingResult first = train_for(experiment, directory.path(), false, 4);
      EXPECT_EQ(first.outcome, TrainOutcome::kInterrupted);
      EXPECT_EQ(first.steps_done, 4);
      const TrainingResult second = train_for(experiment, directory.path(), true, 13);
      EXPECT_EQ(second.outcome, TrainOutcome::kInterrupted);
      EXPECT_EQ(second.steps_done, 17);
      experiment.threads = 2;
      const TrainingResult last = train_for(experiment, directory.path(), true, 1000);
      EXPECT_EQ(last.outcome, whole.outcome);
      EXPECT_EQ(codegen::to_json(last.model), codegen::to_json(whole.model)) << optimiser << ", ema " << ema;
      ASSERT_EQ(last.metrics.size(), whole.metrics.size());
      for (std::size_t i = 0; i < last.metrics.size(); ++i) {
        EXPECT_EQ(last.metrics[i].step, whole.metrics[i].step);
        EXPECT_EQ(last.metrics[i].loss, whole.metrics[i].loss);
        EXPECT_EQ(last.metrics[i].validation_rmse, whole.metrics[i].validation_rmse);
      }
      EXPECT_NE(codegen::to_json(first.model), codegen::to_json(whole.model)) << "control: the rest of the run counts";
    }
  }
}

TEST(Train, EveryStructureGivesTheSameBytesForAnyNumberOfThreadsAndAfterAResume) {
  struct Variant {
    const char* name;
    std::function<void(Experiment&)> change;
  };
  const std::vector<Variant> variants = {
      {"luenberger", [](Experiment& e) { testing::make_luenberger(e); }},
      {"general", [](Experiment& e) { e.observer.structure = "general"; }},
      {"kkl by adjoint", [](Experiment& e) { e.training.gradient = LatentGradient::kAdjoint; }},
      {"kkl with T", [](Experiment& e) { e.loss.weights["map_consistency"] = e.loss.weights["reconstruction"] = 1.0; }},
      {"a terminal cost", [](Experiment& e) { e.loss.weights["terminal"] = 1.0; }},
  };
  for (const Variant& variant : variants) {
    SCOPED_TRACE(variant.name);
    Experiment experiment = small_experiment();
    variant.change(experiment);
    experiment.dynamics.hidden = experiment.forward_map.hidden = {4};
    experiment.training.mode = TrainingMode::kFullBatch;
    const TrainingResult whole = train_here(experiment);
    ASSERT_EQ(whole.outcome, TrainOutcome::kFinished) << whole.message;
    EXPECT_LT(whole.metrics.back().validation_rmse, whole.metrics.front().validation_rmse) << "nothing was learned";
    experiment.threads = 3;
    EXPECT_EQ(codegen::to_json(train_here(experiment).model), codegen::to_json(whole.model));
    const ScratchDirectory directory;
    EXPECT_EQ(train_for(experiment, directory.path(), false, 6).outcome, TrainOutcome::kInterrupted);
    EXPECT_EQ(codegen::to_json(train_for(experiment, directory.path(), true, 1000).model),
              codegen::to_json(whole.model));
  }
}

TEST(Train, ResumingAFinishedRunChangesNothing) {
  const Experiment experiment = small_experiment();
  const ScratchDirectory directory;
  TrainOptions options = writing_to(directory);
  const std::string bytes = codegen::to_json(train_here(experiment, options).model);
  options.resume = true;
  const TrainingResult again = train_here(experiment, options);
  EXPECT_EQ(again.outcome, TrainOutcome::kFinished);
  EXPECT_EQ(codegen::to_json(again.model), bytes);
}

/// What a training in `directory` has written so far.
TrainingState state_in(const std::string& directory, const ObserverStructure& structure, const Experiment& experiment) {
  const std::string path = directory + "/checkpoint.bin", bytes = codegen::read_file(path);
  const auto parameters = static_cast<std::size_t>(structure.parameters());
  CheckpointOwner owner{.parameters = parameters,
                        .memory = 2 * parameters,  // Adam's
                        .eigenvalues = structure.eigenvalues_at(std::vector<float>(parameters).data()).size(),
                        .steps = experiment.training.steps};
  std::memcpy(&owner.fingerprint, bytes.data() + bytes.find('\n') + 1, sizeof owner.fingerprint);
  return read_checkpoint(path, owner);
}

TEST(Train, AveragesWeightsWithAMemoryThatGrowsToItsLength) {
  // a <- a + (1 - k) (p - a), k = min(ema, (1 + t) / (10 + t)): .1, 2/11, then .25 and no longer.
  constexpr double kKept[] = {0.1, 2.0 / 11.0, 0.25, 0.25};
  constexpr double kFloat = 1e-6;
  Experiment experiment = small_experiment();
  experiment.training.ema = 0.25;
  const Dataset data = training_set();
  const ObserverStructure structure =
      make_structure(experiment, needs_forward_map(experiment.loss), data.outputs, data.states);
  const ScratchDirectory directory;
  const std::atomic<bool> at_once = true;
  TrainOptions options = writing_to(directory);
  options.stop = &at_once;
  (void)train_here(experiment, options);
  TrainingState state = state_in(directory.path(), structure, experiment);
  EXPECT_EQ(state.average, state.parameters) << "where it begins";
  double moved = 0.0;
  for (const double kept : kKept) {
    const std::vector<float> before = state.average;
    train_for(experiment, directory.path(), true, 1);
    state = state_in(directory.path(), structure, experiment);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double p = static_cast<double>(state.parameters[i]), a = static_cast<double>(before[i]);
      ASSERT_NEAR(state.average[i], kept * a + (1.0 - kept) * p, kFloat * (1.0 + std::abs(p))) << state.step;
      moved = std::max(moved, std::abs(p - a));
    }
  }
  EXPECT_EQ(state.step, 4);
  EXPECT_GT(moved, 1e3 * kFloat) << "control";
}

TEST(Train, StoppedBeforeItsFirstStepReturnsTheInitialModel) {
  const std::atomic<bool> stop = true;
  TrainOptions options;
  options.stop = &stop;
  const TrainingResult result = train_here(small_experiment(), options);
  EXPECT_EQ(result.outcome, TrainOutcome::kInterrupted);
  EXPECT_EQ(result.steps_done, 0);
  EXPECT_FALSE(codegen::to_json(result.model).empty());
}

TEST(Train, RefusesToResumeFromADamagedCheckpointAndLeavesAllFilesAsTheyWere) {
  const Experiment experiment = small_experiment();
  const ScratchDirectory directory;
  (void)train_for(experiment, directory.path(), false, 5);
  const std::string checkpoint = directory.path("checkpoint.bin");
  const std::string whole = codegen::read_file(checkpoint);
  const std::string metrics = codegen::read_file(directory.path("metrics.csv"));
  const TrainOptions resume = writing_to(directory, true);
  std::vector<std::string> bad;
  for (const double share : {0.0, 0.01, 0.1, 0.5, 0.9, 0.999}) {
    std::string flipped = whole;
    char& byte = flipped[static_cast<std::size_t>(share * static_cast<double>(whole.size()))];
    byte = static_cast<char>(byte ^ 0x10);
    bad.push_back(flipped);
    bad.push_back(whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
  }
  for (const std::string& content : bad) {
    codegen::write_file_atomically(checkpoint, content);
    const std::string message = error_of(experiment, training_set(), validation_set(), resume);
    EXPECT_THAT(message, HasSubstr(checkpoint));
    EXPECT_THAT(message, HasSubstr("without --resume"));
    EXPECT_EQ(codegen::read_file(checkpoint), content);
    EXPECT_EQ(codegen::read_file(directory.path("metrics.csv")), metrics);
  }
  codegen::write_file_atomically(checkpoint, whole);
  EXPECT_EQ(error_of(experiment, training_set(), validation_set(), resume), "no error") << "control: undamaged";
}

TEST(Train, RefusesToResumeFromTheCheckpointOfAnotherExperimentSeedOrDataSet) {
  const Experiment experiment = small_experiment();
  const ScratchDirectory directory;
  (void)train_for(experiment, directory.path(), false, 5);
  const std::string before = codegen::read_file(directory.path("checkpoint.bin"));
  const TrainOptions resume = writing_to(directory, true);
  Experiment other = experiment;
  other.source_text += " of another kind";
  EXPECT_THAT(error_of(other, training_set(), validation_set(), resume), HasSubstr("another experiment"));
  other = experiment;
  other.seed += 1;
  EXPECT_THAT(error_of(other, training_set(), validation_set(), resume), HasSubstr("another experiment"));
  Dataset changed = training_set();
  changed.trajectories[3].outputs(0, 7) += 1e-9;
  EXPECT_THAT(error_of(experiment, changed, validation_set(), resume), HasSubstr("data set"));
  changed = validation_set();
  changed.trajectories[1].weight(0) = 0.0;
  EXPECT_THAT(error_of(experiment, training_set(), changed, resume), HasSubstr("data set"));
  EXPECT_EQ(codegen::read_file(directory.path("checkpoint.bin")), before);
}

TEST(Train, ResumingWithoutACheckpointNamesTheMissingFile) {
  const ScratchDirectory directory;
  EXPECT_THAT(error_of(small_experiment(), training_set(), validation_set(), writing_to(directory, true)),
              HasSubstr(directory.path("checkpoint.bin")));
}

/// Diverges by rule, at whatever pace: keeps the best model so far and says what to try.
void expect_divergence(const Experiment& experiment) {
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

TEST(Train, ADivergingDescentStopsKeepsTheBestModelAndSaysWhatToTry) {
  Experiment experiment = small_experiment();
  experiment.training.optimiser = "gradient_descent";
  experiment.training.learning_rate = 1e6;
  expect_divergence(experiment);
}

TEST(Train, ADivergingAdamStopsKeepsTheBestModelAndSaysWhatToTry) {
  Experiment experiment = small_experiment();
  experiment.training.learning_rate = 1e12;
  experiment.training.eigenvalue_learning_rate = 1e-3;
  experiment.training.schedule = "constant";
  expect_divergence(experiment);
}

TEST(Train, ARunAwayGoesOnFromItsBestWhereGradientsAreClipped) {
  // A rate that grows by half each step throws the run off in the end, again and again. Clipped, it comes back each
  // time, to its last step or to the most returns there are; not clipped, it goes astray.
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

TEST(Train, EigenvaluesThatOverflowAreADivergence) {
  // One Adam step moves log|lambda| by the rate: exp(1000) is infinite, and no number of halvings makes it small.
  Experiment experiment = small_experiment();
  experiment.training.eigenvalue_learning_rate = 1000.0;
  expect_divergence(experiment);
}

TEST(Train, KeepsTheBestModelNotTheLast) {
  // A run that goes astray late: the model is of the lowest validation error on record.
  Experiment experiment = small_experiment();
  experiment.training.learning_rate = 0.01;
  experiment.training.schedule = "exponential";  // growing: the run learns first and is thrown off in the end
  experiment.training.decay = 1.3;
  experiment.training.validate_every = 1;
  const TrainingResult result = train_here(experiment);
  double lowest = result.metrics.front().validation_rmse;
  for (const MetricsRow& row : result.metrics) lowest = std::min(lowest, row.validation_rmse);
  EXPECT_EQ(result.validation_rmse, lowest);
  EXPECT_LT(lowest, result.metrics.back().validation_rmse) << "control: the last one is worse";
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
    ASSERT_EQ(calls[i].eigenvalues.size(), 3U) << "a pair is one";
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

TEST(Train, HoldsEigenvaluesThatAreNotToBeLearned) {
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

TEST(Train, RefusesToStartFromWhatIsNotFinite) {
  Experiment unstable = small_experiment();
  unstable.observer.hold = Hold::kRk4;
  unstable.observer.eigenvalues = {-200.0};  // 10 per sample period
  EXPECT_THAT(error_of(unstable, harmonics({400, 400}, false), validation_set()), HasSubstr("first_order"));
  Dataset broken = validation_set();
  broken.trajectories[1].states(0, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error_of(small_experiment(), training_set(), broken), HasSubstr("not finite"));
}

TEST(Train, ADrawOfMaskedSamplesAloneIsNoDivergence) {
  // One sample in a hundred counts, and four are drawn per step: most steps have nothing to learn from.
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

TEST(Train, JitteredLogsTakeSegmentLengthsByTheNominalPeriod) {
  // A first step ten times as long as the others must not decide how long a segment of one second is.
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
  // The same segments and ticks; only what follows the gap in run 0 differs, a little. Segments of a tenth of the
  // length would change the loss by much more, as most of their samples lie in the transient from z = 0.
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
      train(experiment, testing::van_der_pol(20, 15.0, 1), testing::van_der_pol(4, 15.0, 2), {});
  EXPECT_EQ(result.outcome, TrainOutcome::kFinished);
  // What is left is the transient from z = 0, which no map of z can undo.
  EXPECT_LT(result.validation_rmse, 0.3 * result.metrics.front().validation_rmse);
  EXPECT_LT(testing::plain_rmse(result.model, testing::van_der_pol(4, 15.0, 3)), 0.5)
      << "on runs it has never seen, noise-free, the transient from z = 0 included";
}

}  // namespace
}  // namespace nlo::trainer
