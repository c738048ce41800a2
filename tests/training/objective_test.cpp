// SPDX-License-Identifier: MIT
// The cost and the error: they are those of the written model, in the requested units.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "tests/training/objective_problem.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;
using testing::kUnequal;
using testing::masked;
using testing::Problem;
using testing::small_experiment;
using testing::Variant;
using testing::variants;

/// Divides estimates and truth of each state by its scale.
void in_units_of(const std::vector<float>& scale, codegen::Model& model, Dataset& dataset) {
  const Eigen::VectorXd units =
      Eigen::VectorXf::Map(scale.data(), static_cast<Eigen::Index>(scale.size())).cast<double>();
  codegen::inverse_map(model)->output_mean.array() /= units.array();
  codegen::inverse_map(model)->output_scale.array() /= units.array();
  for (Trajectory& run : dataset.trajectories) run.states.array().colwise() /= units.array();
}

TEST(Objective, ErrorEqualsThatOfTheWrittenModel) {
  // Training agrees with the model that it writes, except for float32 in the filter and in T*.
  constexpr double kTolerance = 2e-6;
  // Flight splits the long steps of jittered samples, which changes the error of RK4.
  constexpr double kOdeTolerance = 1e-5;
  for (const bool jittered : {false, true}) {
    for (const Variant& variant : variants()) {
      SCOPED_TRACE(variant.name);
      Experiment experiment = small_experiment();
      variant.change(experiment);
      experiment.training.noise = {};
      Problem problem(experiment, masked(harmonics(kUnequal, jittered)));
      const double rmse = problem.objective.validate(problem.parameters.data());
      codegen::Model model = to_model(problem.structure, problem.parameters.data(), experiment, problem.dataset,
                                      problem.objective.rollout());
      Dataset dataset = problem.dataset;
      if (experiment.loss.is_normalised()) in_units_of(problem.structure.state_scale, model, dataset);
      const double flown = codegen::linear_latent(model) != nullptr ? testing::plain_rmse(model, dataset)
                                                                    : testing::reference_rmse(model, dataset);
      EXPECT_NEAR(rmse, flown, (codegen::linear_latent(model) != nullptr ? kTolerance : kOdeTolerance) * rmse);
    }
  }
}

TEST(Objective, ModelRecordsTheLargestActivationsAlsoOfMaskedSamples) {
  constexpr double kTolerance = 1e-4;  // float32 of the filter
  Experiment experiment = small_experiment();
  experiment.inverse_map.activation = "relu";
  experiment.observer.features = FeatureSet::kLatentAndOutput;
  experiment.training.noise = {};
  Dataset dataset = harmonics(kUnequal, false);
  dataset.trajectories[2].outputs.col(5) *= 50.0;  // a mask concerns the truth; the observer reads this sample
  for (Eigen::Index k = 5; k < dataset.trajectories[2].samples(); ++k) dataset.trajectories[2].weight(k) = 0.0;
  Problem problem(experiment, dataset);
  const codegen::Model model =
      to_model(problem.structure, problem.parameters.data(), experiment, problem.dataset, problem.objective.rollout());
  const codegen::Network& map = *codegen::inverse_map(model);
  std::vector<double> largest(map.layers.size() - 1, 0.0);
  for (const Trajectory& run : problem.dataset.trajectories) {
    Eigen::MatrixXd in(model.nz() + model.ny(), run.samples());
    in << codegen::ReferenceObserver<double>(model).run(run.outputs, {}, run.time_s, true).z, run.outputs;
    for (Eigen::Index k = 0; k < run.samples(); ++k) {
      Eigen::VectorXd a = (map.features * in.col(k) - map.feature_mean).cwiseQuotient(map.feature_scale);
      for (std::size_t l = 0; l < largest.size(); ++l) {
        a = (map.layers[l].weights * a + map.layers[l].bias).cwiseMax(0.0).eval();
        largest[l] = std::max(largest[l], a.maxCoeff());
      }
    }
  }
  ASSERT_EQ(map.largest_activations.size(), largest.size());
  for (std::size_t l = 0; l < largest.size(); ++l)
    EXPECT_NEAR(map.largest_activations[l], largest[l], kTolerance * largest[l]);
}

TEST(Objective, LossIsTheSquaredErrorInItsScale) {
  constexpr double kTolerance = 1e-5;  // float32 sums
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  Problem physical(experiment, harmonics(kUnequal, false));
  const ObjectiveValue value = physical.objective.evaluate(physical.parameters.data(), 0, nullptr);
  EXPECT_NEAR(value.loss, value.rmse * value.rmse, kTolerance * value.loss);

  experiment.loss.scale = ErrorScale::kNormalised;
  Problem normalised(experiment, harmonics(kUnequal, false));
  const codegen::Model model = to_model(normalised.structure, normalised.parameters.data(), experiment,
                                        normalised.dataset, normalised.objective.rollout());
  double expected = 0.0;
  double total = 0.0;
  for (const Trajectory& run : normalised.dataset.trajectories) {
    const Eigen::MatrixXd error = testing::plain_estimates(model, run).states - run.states;
    expected += (codegen::inverse_map(model)->output_scale.cwiseInverse().asDiagonal() * error).squaredNorm();
    total += static_cast<double>(run.samples());
  }
  const ObjectiveValue scaled = normalised.objective.evaluate(normalised.parameters.data(), 0, nullptr);
  EXPECT_NEAR(scaled.loss, expected / total, kTolerance * scaled.loss);
  EXPECT_NEAR(scaled.rmse, std::sqrt(scaled.loss), kTolerance * scaled.rmse) << "the error has the scale of the loss";

  experiment.loss.weights["eigenvalue_penalty"] = 0.1;
  Problem penalised(experiment, harmonics(kUnequal, false));
  const double penalty = penalised.objective.evaluate(penalised.parameters.data(), 0, nullptr).loss - scaled.loss;
  EXPECT_NEAR(penalty, 0.1 * (4.0 + 9.0 + 1.0 + 16.0), kTolerance * penalty) << "(20): gamma |lambda|^2";
}

/// A network with output 0, and runs with truth 0: the loss contains only what a test adds.
struct Blank : Problem {
  explicit Blank(const Experiment& e) : Problem(e, harmonics(kUnequal, false)) {
    std::fill(parameters.begin() + structure.latent.learned, parameters.end(), 0.0F);
    std::fill(structure.state_mean.begin(), structure.state_mean.end(), 0.0F);
    for (auto& run : data.runs) std::fill(run.states.begin(), run.states.end(), 0.0F);
  }
  /// Returns the truth of a state of a run, from the first sample on.
  std::span<float> truth(std::size_t run, std::size_t state) {
    const auto samples = static_cast<std::size_t>(data.runs[run].samples);
    return std::span(data.runs[run].states).subspan(state * samples, samples);
  }
};

Experiment full_batch() {
  Experiment experiment = small_experiment();
  experiment.training.mode = TrainingMode::kFullBatch;
  return experiment;
}

constexpr double kFloatSums = 1e-6;

TEST(Objective, IntegralIsTheMeanTimesTheMeanLengthOfTheSegments) {
  // |x - x_hat|^2 = 4 everywhere. Runs of 40 + 25 + ... + 7 = 396 samples, 385 steps of .05 s, are 1.75 s long on
  // average.
  Experiment experiment = full_batch();
  for (const auto& [reduction, expected] : {std::pair{Reduction::kMean, 4.0}, {Reduction::kIntegral, 4.0 * 1.75}}) {
    experiment.loss.reduction = reduction;
    Blank blank(experiment);
    for (std::size_t run = 0; run < kUnequal.size(); ++run) std::ranges::fill(blank.truth(run, 0), 2.0F);
    EXPECT_NEAR(blank.loss(blank.parameters, 0), expected, kFloatSums * expected);
    EXPECT_NEAR(blank.objective.validate(blank.parameters.data()), 2.0, kFloatSums)
        << "the validation error does not depend on the loss";
  }
}

TEST(Objective, LogarithmWeighsGroupsEquallyForAnyErrors) {
  // |x - x_hat|^2 = 1e-2 in the first eight of 11 runs and 100 in the other three: the mean of both logarithms.
  Experiment experiment = full_batch();
  experiment.loss.reduction = Reduction::kLogarithm;
  Blank blank(experiment);
  for (std::size_t run = 0; run < kUnequal.size(); ++run)
    std::ranges::fill(blank.truth(run, 0), run < 8 ? 0.1F : 10.0F);
  double floor = 0.0;
  for (const float scale : blank.structure.state_scale) floor += std::pow(0.005 * static_cast<double>(scale), 2);
  const double expected = 0.5 * (std::log(1e-2 + floor) + std::log(100.0 + floor));
  EXPECT_NEAR(blank.loss(blank.parameters, 0), expected, kFloatSums * std::log(100.0));
}

TEST(Objective, TerminalCostIsTheMeanOverTheEndsOfSegments) {
  // |x - x_hat|^2 = 9 only at ends: of `ends` of 11 runs, and at as many of 396 samples.
  Experiment experiment = full_batch();
  experiment.loss.weights["terminal"] = 0.8;
  experiment.loss.weights["state_error"] = 0.5;
  for (const std::size_t ends : {kUnequal.size(), std::size_t{1}}) {
    Blank blank(experiment);
    for (std::size_t run = 0; run < ends; ++run) blank.truth(run, 1).back() = 3.0F;
    const auto count = static_cast<double>(ends);
    const double expected = 0.8 * 9.0 * count / 11.0 + 0.5 * 9.0 * count / 396.0;
    EXPECT_NEAR(blank.loss(blank.parameters, 0), expected, kFloatSums * expected) << ends;
  }
}

/// Validation error of the same network, with the position in units of `metres`.
double validated(ErrorScale scale, double metres) {
  Experiment experiment = small_experiment();
  experiment.loss.scale = scale;
  Dataset dataset = harmonics(kUnequal, false);
  for (Trajectory& run : dataset.trajectories) run.states.row(0) /= metres;
  Problem problem(experiment, dataset);
  return problem.objective.validate(problem.parameters.data());
}

TEST(Objective, ChoiceOfTheModelDoesNotDependOnUnitsIfTheLossIsNormalised) {
  constexpr double kFloat = 1e-5;  // sums of some 400 squares in float32
  const double in_metres = validated(ErrorScale::kNormalised, 1.0);
  EXPECT_NEAR(validated(ErrorScale::kNormalised, 1e-3), in_metres, kFloat * in_metres);
  EXPECT_GT(validated(ErrorScale::kPhysical, 1e-3), 100.0 * validated(ErrorScale::kPhysical, 1.0))
      << "control: the result depends on the unit";
}

}  // namespace
}  // namespace nlo::trainer
