// SPDX-License-Identifier: MIT
// A training gives the same bytes for any number of threads and interruptions, or an error with the reason.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <vector>

#include "codegen/base/file.h"
#include "codegen/model_file/model_file.h"
#include "tests/training/small_trainings.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/learn/training/checkpoint.h"
#include "trainer/structures/structure.h"

namespace nlo::trainer {
namespace {

using ::testing::HasSubstr;

/// An experiment with all parts of a step: noise, segments, pairs, averages, decay, a linear path.
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

TEST(Resume, ResumedRunsGiveTheBytesOfAnUninterruptedRun) {
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
      EXPECT_NE(codegen::to_json(first.model), codegen::to_json(whole.model))
          << "control: the rest of the run changes the model";
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

TEST(Resume, ResumingAFinishedRunChangesNothing) {
  const Experiment experiment = small_experiment();
  const ScratchDirectory directory;
  TrainOptions options = writing_to(directory);
  const std::string bytes = codegen::to_json(train_here(experiment, options).model);
  options.resume = true;
  const TrainingResult again = train_here(experiment, options);
  EXPECT_EQ(again.outcome, TrainOutcome::kFinished);
  EXPECT_EQ(codegen::to_json(again.model), bytes);
}

/// Returns the state that a training in `directory` has written.
TrainingState state_in(const std::string& directory, const ObserverStructure& structure, const Experiment& experiment) {
  const std::string path = directory + "/checkpoint.bin", bytes = codegen::read_file(path);
  const auto parameters = static_cast<std::size_t>(structure.parameters());
  CheckpointOwner owner{.parameters = parameters,
                        .memory = 2 * parameters,  // Adam stores two moments
                        .eigenvalues = structure.eigenvalues_at(std::vector<float>(parameters).data()).size(),
                        .steps = experiment.training.steps};
  std::memcpy(&owner.fingerprint, bytes.data() + bytes.find('\n') + 1, sizeof owner.fingerprint);
  return read_checkpoint(path, owner);
}

TEST(Train, AveragesWeightsWithAMemoryThatGrowsToItsLength) {
  // a <- a + (1 - k) (p - a), k = min(ema, (1 + t) / (10 + t)): .1, 2/11, then constant at .25.
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
  EXPECT_EQ(state.average, state.parameters) << "the average starts at the parameters";
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

TEST(Resume, RefusesToResumeFromADamagedCheckpointAndChangesNoFile) {
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

TEST(Resume, RefusesToResumeFromTheCheckpointOfAnotherExperimentSeedOrDataSet) {
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

TEST(Resume, ResumingWithoutACheckpointNamesTheMissingFile) {
  const ScratchDirectory directory;
  EXPECT_THAT(error_of(small_experiment(), training_set(), validation_set(), writing_to(directory, true)),
              HasSubstr(directory.path("checkpoint.bin")));
}

}  // namespace
}  // namespace nlo::trainer
