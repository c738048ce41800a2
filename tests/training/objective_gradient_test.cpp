// SPDX-License-Identifier: MIT
// Gradients of the cost compared with differences of the cost.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tests/training/objective_problem.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/structures/structure_table.h"
#include "trainer/structures/unit_settings.h"

namespace nlo::trainer {
namespace {

using testing::harmonics;
using testing::kSomeStep;
using testing::kUnequal;
using testing::masked;
using testing::Problem;
using testing::small_experiment;
using testing::Variant;
using testing::variants;

/// Compares each entry of the gradient with fourth-order central differences of the objective.
void expect_gradient_agrees_with_differences(const Experiment& experiment, const Dataset& dataset,
                                             float step = 0.015F) {
  // The loss is a float32 sum with a relative error of 1e-7: 2e-5 of the loss after division by the step, measured. The
  // truncation error, step^4 / 30 times the fifth derivative, is as large for the steepest variant (silu).
  constexpr double kTolerance = 1.2e-4;
  Problem problem(experiment, dataset);
  const std::vector<float> gradient = problem.gradient(kSomeStep);
  const double loss = problem.loss(problem.parameters, kSomeStep);
  double largest = 0.0;
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    const auto moved = [&](float by) {
      std::vector<float> at = problem.parameters;
      at[i] += by;
      return problem.loss(at, kSomeStep);
    };
    // Parameters are float32, so the real difference is not exactly the step.
    const double width =
        static_cast<double>(problem.parameters[i] + step) - static_cast<double>(problem.parameters[i] - step);
    const double difference =
        (8.0 * (moved(step) - moved(-step)) - (moved(2 * step) - moved(-2 * step))) / (6.0 * width);
    largest = std::max(largest, std::abs(difference));
    ASSERT_NEAR(static_cast<double>(gradient[i]), difference, kTolerance * (1.0 + loss)) << "parameter " << i;
  }
  ASSERT_GT(largest, 200.0 * kTolerance * (1.0 + loss)) << "the tolerance would pass a gradient of zero";
}

void expect_every_variant_agrees_with_differences(const Dataset& dataset) {
  for (const Variant& variant : variants()) {
    SCOPED_TRACE(variant.name);
    Experiment experiment = small_experiment();
    variant.change(experiment);
    expect_gradient_agrees_with_differences(experiment, dataset);
    if (::testing::Test::HasFatalFailure()) return;
  }
}

TEST(Objective, GradientAgreesWithDifferencesInEveryVariant) {
  expect_every_variant_agrees_with_differences(harmonics(kUnequal, false));
}

TEST(Objective, GradientAgreesWithDifferencesOnJitteredSamples) {
  expect_every_variant_agrees_with_differences(harmonics(kUnequal, true));
}

TEST(Objective, GradientAgreesWithDifferencesOnWeightedSamples) {
  expect_every_variant_agrees_with_differences(masked(harmonics(kUnequal, false)));
}

/// Each loss with each structure that supports it.
TEST(Objective, GradientAgreesWithDifferencesForEveryLossAndStructure) {
  for (const TrainableStructure* structure : structure_table()) {
    if (structure->name() == "carried") continue;  // tested in carried_test.cpp
    if (structure->name() == "prior") continue;    // tested in prior_test.cpp
    for (const LossTerm& term : loss_terms()) {
      if (term.needs_eigenvalues && !structure->has_eigenvalues()) continue;
      SCOPED_TRACE(std::string(structure->name()) + ", " + std::string(term.name));
      Experiment experiment = small_experiment();
      if (structure->name() == "luenberger") testing::make_luenberger(experiment);
      experiment.observer.structure = structure->name();
      // Slow units hardly move in such short runs, and their normalised values are too steep for such wide differences.
      experiment.observer.own.set<UnitSettings>() = {.units = 4, .rates = {4.0, 12.0}};
      experiment.dynamics.hidden = {5};
      experiment.forward_map.hidden = {4};
      experiment.loss.weights = {{"state_error", 0.5}, {std::string(term.name), 0.5}};
      Dataset dataset = harmonics(kUnequal, false);
      if (term.needs_equations)
        for (Trajectory& run : dataset.trajectories) run.derivatives = 0.5 * run.states;  // any f will do
      // The loss of gated units, which run through time, has a larger fifth derivative.
      expect_gradient_agrees_with_differences(experiment, dataset, structure->name() == "gated" ? 0.004F : 0.015F);
      if (::testing::Test::HasFatalFailure()) return;
    }
  }
}

}  // namespace
}  // namespace nlo::trainer
