// SPDX-License-Identifier: MIT
// The samples of a step and their weights: masks, weights, draws, noise, mirrors.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/training/objective_problem.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;
using testing::kSomeStep;
using testing::kUnequal;
using testing::Problem;
using testing::small_experiment;

/// Loss and gradient with the truth of one sample moved far away; the normalisation stays that of `problem`.
std::pair<double, std::vector<float>> with_truth_moved(Problem& problem, int sample) {
  std::vector<float>& states = problem.data.runs[2].states;
  const float before = states[static_cast<std::size_t>(sample)];
  states[static_cast<std::size_t>(sample)] = 1e4F;
  std::pair<double, std::vector<float>> result{problem.loss(problem.parameters, kSomeStep),
                                               problem.gradient(kSomeStep)};
  states[static_cast<std::size_t>(sample)] = before;
  return result;
}

TEST(Objective, MaskedSamplesHaveNoEffect) {
  for (const auto mode : {TrainingMode::kFullBatch, TrainingMode::kRandomSamples}) {
    Experiment experiment = small_experiment();
    experiment.training.mode = mode;
    experiment.training.samples_per_step = 5000;  // so that each sample is drawn
    experiment.training.trajectories_per_step = 60;
    Dataset dataset = harmonics(kUnequal, false);
    dataset.trajectories[2].weight(10) = 0.0;
    Problem problem(experiment, dataset);
    const double loss = problem.loss(problem.parameters, kSomeStep);
    const std::vector<float> gradient = problem.gradient(kSomeStep);
    const auto [masked_loss, masked_gradient] = with_truth_moved(problem, 10);
    EXPECT_EQ(masked_loss, loss) << to_name(mode);
    EXPECT_EQ(masked_gradient, gradient) << to_name(mode);
    const auto [counted_loss, counted_gradient] = with_truth_moved(problem, 11);
    EXPECT_GT(counted_loss, 2.0 * loss) << "control, " << to_name(mode);
    EXPECT_NE(counted_gradient, gradient) << "control, " << to_name(mode);
  }
}

TEST(Objective, ErrorsBeforeAndAfterTheTransientEqualThoseWithOtherSamplesMasked) {
  constexpr double kTolerance = 1e-6;  // sums in another order, in float
  constexpr int kFrom = 30;            // some of the runs end before
  const Dataset data = testing::masked(harmonics(kUnequal, false));
  const auto only = [&data](bool settled) {
    Dataset part = data;
    for (Trajectory& run : part.trajectories)
      for (Eigen::Index k = 0; k < run.samples(); ++k)
        if ((k >= kFrom) != settled) run.weight(k) = 0.0;
    return part;
  };
  Problem problem(small_experiment(), data), transient(small_experiment(), only(false)),
      settled(small_experiment(), only(true));
  for (Problem* part : {&transient, &settled}) part->use_scales_of(problem);
  const float* parameters = problem.parameters.data();
  EXPECT_TRUE(problem.objective.validation(parameters).settled_rmse.empty()) << "no end of the transient is set";
  problem.objective.split_validation_at(kFrom - 0.5);
  const ObjectiveValue split = problem.objective.validation(parameters);
  const std::vector<double> before = transient.objective.validation(parameters).state_rmse,
                            after = settled.objective.validation(parameters).state_rmse;
  ASSERT_EQ(split.transient_rmse.size(), before.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    EXPECT_NEAR(split.transient_rmse[i], before[i], kTolerance * before[i]);
    EXPECT_NEAR(split.settled_rmse[i], after[i], kTolerance * after[i]);
  }
  problem.objective.split_validation_at(1000.0);
  EXPECT_TRUE(problem.objective.validation(parameters).transient_rmse.empty()) << "no run is so long";
}

TEST(Objective, IsBehindAFilterIfAStateHasALargerErrorOverWholeRunsOrWindows) {
  const std::vector<double> deviations = {1.0, 10.0};
  const ObjectiveValue filter{
      .rmse = 0.5, .state_rmse = {0.3, 0.4}, .transient_rmse = {0.6, 0.8}, .settled_rmse = {0.02, 1e-5}};
  const auto is_behind_with = [&](double whole, double transient, double settled) {
    ObjectiveValue observer = filter;
    observer.state_rmse[0] *= whole;
    observer.transient_rmse[0] *= transient;
    observer.settled_rmse[0] *= settled;
    return is_behind(observer, filter, deviations);
  };
  EXPECT_FALSE(is_behind_with(1.019, 1.019, 1.019));
  EXPECT_TRUE(is_behind_with(1.021, 1.0, 1.0));
  EXPECT_TRUE(is_behind_with(1.0, 1.021 * 1.021, 1.0));
  EXPECT_TRUE(is_behind_with(0.99, 0.99, 2.0)) << "the settled error doubles, which hardly shows over whole runs";
  EXPECT_FALSE(is_behind_with(0.9, 1.1, 0.5)) << "the settled error falls by more than the transient one grows";

  ObjectiveValue observer = filter;
  observer.settled_rmse[1] = 0.0104;  // the filter's error counts as 0.001 deviations; 1.02^2 of that is the limit
  EXPECT_FALSE(is_behind(observer, filter, deviations));
  observer.settled_rmse[1] = 0.0105;
  EXPECT_TRUE(is_behind(observer, filter, deviations));
  observer.settled_rmse.clear();
  observer.transient_rmse.clear();
  EXPECT_FALSE(is_behind(observer, filter, deviations)) << "runs without an end of the transient have no windows";
}

TEST(Objective, TwoRunsOfWeightOneHalfEqualOneRun) {
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  const Dataset once = harmonics(kUnequal, false);
  Dataset twice = once;
  for (Trajectory& run : twice.trajectories) run.weight *= 0.5;
  const std::vector<Trajectory> copy = twice.trajectories;
  twice.trajectories.insert(twice.trajectories.end(), copy.begin(), copy.end());
  Problem one(experiment, once);
  Problem two(experiment, twice);
  constexpr double kTolerance = 1e-6;  // float32, summed in another order
  EXPECT_NEAR(two.loss(one.parameters, 0), one.loss(one.parameters, 0), kTolerance * one.loss(one.parameters, 0));
}

TEST(Objective, RandomSamplesAgreeWithFullBatchesInExpectation) {
  // Whole runs and short segments of runs of unequal length with different errors: each sample must be equally likely.
  constexpr int kSteps = 400;
  constexpr double kStandardErrors = 4.0;
  // Runs of 100 samples or more: segments reach the first and last samples of a run less often than the others.
  const Dataset dataset = harmonics({100, 300, 200, 150, 260, 120, 300, 180, 110, 220, 130}, false);
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  Problem full(experiment, dataset);
  const double expected = full.loss(full.parameters, 0);
  experiment.training.mode = TrainingMode::kRandomSamples;
  experiment.training.trajectories_per_step = 64;
  experiment.training.samples_per_step = 64 * 16;
  Problem random(experiment, dataset);
  random.use_scales_of(full);
  double sum = 0.0;
  double squares = 0.0;
  for (long step = 0; step < kSteps; ++step) {
    const double loss = random.loss(full.parameters, step);
    sum += loss;
    squares += loss * loss;
  }
  const double mean = sum / kSteps;
  const double error = std::sqrt((squares / kSteps - mean * mean) / kSteps);
  EXPECT_NEAR(mean, expected, kStandardErrors * error);
  EXPECT_LT(kStandardErrors * error, 0.02 * expected) << "control: the bound is sharp";
}

TEST(Objective, EarlyShareDrawsThatShareOfTheSamplesFromTheStart) {
  // Only samples before early_s are wrong, by a known amount, so the loss shows their share.
  Experiment experiment = small_experiment();
  experiment.training.early_s = 0.5;  // 10 of 200 samples
  experiment.training.early_share = 0.4;
  experiment.training.trajectories_per_step = 64;
  experiment.training.samples_per_step = 64 * 50;
  Problem problem(experiment, harmonics(std::vector<int>(8, 200), false));
  const double before = problem.loss(problem.parameters, 0);
  for (auto& run : problem.data.runs) {
    for (std::size_t k = 0; k < 10; ++k) run.states[k] += 1000.0F;
  }
  const double share = (problem.loss(problem.parameters, 0) - before) / 1e6;
  // early_share takes 20 of 50 samples, and chance one in twenty of the other 30; tolerance: half a sample of error.
  EXPECT_NEAR(share, 0.4 + 0.6 / 20.0, 0.02);
}

TEST(Objective, DrawsAreNewInEachStepAndReproducible) {
  Experiment experiment = small_experiment();
  experiment.training.noise = {NoiseKind::kGaussian, 0.3};
  for (const auto mode : {TrainingMode::kFullBatch, TrainingMode::kRandomSamples}) {
    experiment.training.mode = mode;
    Problem problem(experiment, harmonics(kUnequal, false));
    const double first = problem.loss(problem.parameters, 0);
    EXPECT_NE(problem.loss(problem.parameters, 1), first) << to_name(mode);
    EXPECT_EQ(problem.loss(problem.parameters, 0), first) << to_name(mode);
    const double validated = problem.objective.validate(problem.parameters.data());
    problem.loss(problem.parameters, 7);
    EXPECT_EQ(problem.objective.validate(problem.parameters.data()), validated) << to_name(mode);
  }
}

TEST(Objective, NoiseHasTheGivenStandardDeviation) {
  Experiment experiment = small_experiment();
  const Dataset dataset = harmonics(std::vector<int>(40, 500), false);
  for (const auto& [kind, deviation] :
       {std::pair{NoiseKind::kGaussian, 0.3}, std::pair{NoiseKind::kUniform, 0.3 / std::sqrt(3.0)}}) {
    experiment.training.noise = {kind, 0.3};
    Problem problem(experiment, dataset);
    const Rollout& rollout = problem.objective.roll_out_flight(problem.parameters.data());
    double sum = 0.0;
    double squares = 0.0;
    double count = 0.0;
    for (std::size_t g = 0; g < rollout.groups().size(); ++g) {
      const SegmentGroup& group = rollout.groups()[g];
      for (int l = 0; l < group.lanes; ++l) {
        const auto& run = problem.data.runs[static_cast<std::size_t>(rollout.segment(static_cast<int>(g), l).run)];
        for (int t = 0; t < group.length; ++t, count += 1.0) {
          const auto noise = static_cast<double>(group.readings[group.at(0, t) + static_cast<std::size_t>(l)] -
                                                 run.readings[static_cast<std::size_t>(t)]);
          sum += noise;
          squares += noise * noise;
        }
      }
    }
    // Five standard errors of a mean and of a standard deviation.
    EXPECT_NEAR(sum / count, 0.0, 5.0 * deviation / std::sqrt(count));
    EXPECT_NEAR(std::sqrt(squares / count), deviation, 5.0 * deviation / std::sqrt(2.0 * count));
  }
}

TEST(Objective, MirroredRunsOfAnOddMapCostTheSame) {
  // Tanh networks without biases and means are odd, so the error of a mirrored run is the same.
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  Problem plain(experiment, harmonics(kUnequal, false));
  experiment.training.mirror = true;
  Problem mirrored(experiment, harmonics(kUnequal, false));
  mirrored.use_scales_of(plain);
  mirrored.parameters = plain.parameters;
  for (Problem* problem : {&plain, &mirrored}) {
    for (Feature& feature : problem->structure.features) feature.mean = 0.0F;
    for (float& mean : problem->structure.state_mean) mean = 0.0F;
    for (const LayerView& layer : problem->structure.network.layers) {
      for (int o = 0; o < layer.out; ++o) {
        problem->parameters[static_cast<std::size_t>(problem->structure.latent.learned + layer.bias + o)] = 0.0F;
      }
    }
  }
  const double loss = plain.loss(plain.parameters, 0);
  EXPECT_NEAR(mirrored.loss(plain.parameters, 0), loss, 1e-6 * loss);
  plain.structure.state_mean[0] = mirrored.structure.state_mean[0] = 1.0F;
  const double shifted = plain.loss(plain.parameters, 0);
  EXPECT_GT(std::abs(mirrored.loss(plain.parameters, 0) - shifted), 1e-3 * shifted)
      << "control: some runs are mirrored";
}

}  // namespace
}  // namespace nlo::trainer
