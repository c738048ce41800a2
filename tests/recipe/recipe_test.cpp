// SPDX-License-Identifier: MIT
#include "trainer/recipe/recipe.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "codegen/base/error.h"
#include "trainer/experiments/shipped.h"
#include "trainer/experiments/training_sets.h"

namespace nlo::trainer {
namespace {

using testing::HasSubstr;

const std::string kDraft = R"(name = "draft"
[plant]
model = "van_der_pol"
[simulation]
horizon_s = 10.0
sample_period_s = 0.05
initial_low = [-1.0, -1.0]
initial_high = [1.0, 1.0]
[training]
trajectories_per_step = 8  # quick pilots: what is derived here does not hang on them
samples_per_step = 256
)";

Recipe derived(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const DraftExperiment draft = parse_draft(text, "draft.toml", overrides);
  EXPECT_FALSE(draft.complete);
  const TrainingSets sets = simulate_training_sets(experiment_for_data(draft));
  return derive_recipe(draft, sets.training, sets.validation);
}

TEST(Draft, IsWhatGivesNoEigenvalues) {
  EXPECT_FALSE(parse_draft(kDraft, "d.toml").complete);
  EXPECT_TRUE(parse_draft(kDraft, "d.toml", {"observer.eigenvalues=[-1.0]"}).complete);
  EXPECT_TRUE(parse_draft(kDraft, "d.toml", {"observer.structure=gated"}).complete);
  EXPECT_THROW(parse_experiment(kDraft, "d.toml"), codegen::Error);
  EXPECT_THROW(parse_draft(kDraft, "d.toml", {"observer.eigenvalues=[]"}), codegen::Error) << "given, and empty";
}

TEST(Draft, LeavesShippedExperimentsAsTheyAre) {
  for (const ShippedExperiment& shipped : shipped_experiments()) {
    const DraftExperiment draft = parse_draft(shipped.text, std::string(shipped.name));
    EXPECT_TRUE(draft.complete) << shipped.name;
    EXPECT_EQ(draft.experiment.source_text, parse_experiment(shipped.text, std::string(shipped.name)).source_text);
  }
}

TEST(Draft, IsToldFromOneThatGivesADefaultItself) {
  EXPECT_NE(parse_draft(kDraft, "d.toml").experiment.source_text,
            parse_draft(kDraft, "d.toml", {"training.steps=1000"}).experiment.source_text);
}

TEST(Recipe, ReadsBackToTheSameExperiment) {
  const Recipe recipe = derived(kDraft);
  const Experiment again = parse_experiment(recipe.experiment.source_text, "again");
  EXPECT_EQ(again.source_text, recipe.experiment.source_text);
  EXPECT_FALSE(again.observer.eigenvalues.empty() && again.observer.pairs.empty());
}

TEST(Recipe, IsTheSameForAnyNumberOfThreads) {
  EXPECT_EQ(derived(kDraft, {"threads=1"}).experiment.source_text,
            derived(kDraft, {"threads=3"}).experiment.source_text);
}

TEST(Recipe, KeepsWhatTheFileGives) {
  const Recipe recipe = derived(kDraft, {"observer.clocks_s=[0.7]", "observer.features=latent", "observer.start=zero",
                                         "inverse_map.hidden=[8]", "inverse_map.linear_path=false", "training.steps=77",
                                         "training.mirror=false", "simulation.trajectories=30", "loss.scale=physical"});
  for (const char* line :
       {"clocks_s = [0.7]", "features = \"latent\"", "start = \"zero\"", "hidden = [8]", "linear_path = false",
        "steps = 77", "mirror = false", "trajectories = 30", "scale = \"physical\""})
    EXPECT_THAT(recipe.experiment.source_text, HasSubstr(std::string("\n") + line + "\n")) << line;
}

TEST(Recipe, IsSlowerForASlowerPlant) {
  // The same oscillator by another clock: all times are ten times as long.
  const std::string plant = R"toml(name = "clocked"
[plant]
states = ["a", "b"]
derivative = ["rate*b", "rate*(2*(1 - a^2)*b - a)"]
parameters = { rate = 1.0 }
output_names = ["y"]
outputs = ["a"]
[simulation]
horizon_s = 20.0
sample_period_s = 0.05
initial_low = [-1.0, -1.0]
initial_high = [1.0, 1.0]
[training]
noise = "gaussian:0.1"
trajectories_per_step = 8
samples_per_step = 256
)toml";
  const auto slowest = [](const Experiment& e) {
    double least = 1e9;
    for (const double lambda : e.observer.eigenvalues) least = std::min(least, -lambda);
    for (const auto& pair : e.observer.pairs) least = std::min(least, -pair[0]);
    return least;
  };
  const double fast = slowest(derived(plant).experiment);
  const double slow = slowest(
      derived(plant, {"plant.parameters.rate=0.1", "simulation.horizon_s=200.0", "simulation.sample_period_s=0.5"})
          .experiment);
  EXPECT_NEAR(fast / slow, 10.0, 0.1);
}

TEST(Recipe, DoesNotMirrorWhatStartsOnOneSide) {
  EXPECT_TRUE(derived(kDraft).experiment.training.mirror);
  EXPECT_FALSE(derived(kDraft, {"simulation.initial_low=[0.0, -1.0]"}).experiment.training.mirror);
}

}  // namespace
}  // namespace nlo::trainer
