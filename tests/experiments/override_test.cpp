// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/experiments/experiment_text.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

Experiment overridden(const std::string& assignment) {
  return parse_experiment(kPlantExperiment, "e.toml", {assignment});
}

TEST(Override, ReplacesAValue) {
  EXPECT_EQ(overridden("training.steps=25").training.steps, 25);
  EXPECT_EQ(overridden("seed=9").seed, 9u);
  EXPECT_THAT(overridden("observer.eigenvalues=[-3, -4]").observer.eigenvalues, ElementsAre(-3.0, -4.0));
  EXPECT_EQ(overridden("plant.parameters.mu=2").plant->parameters[0].second, 2.0);
  EXPECT_EQ(overridden("training.noise=\"uniform:3\"").training.noise.of(0).kind, NoiseKind::kUniform);
}

TEST(Override, MakesASectionThatTheFileLeftOut) {
  EXPECT_THAT(overridden("inverse_map.hidden=[8]").inverse_map.hidden, ElementsAre(8));
}

TEST(Override, TakesABareWordAsText) {
  EXPECT_EQ(overridden("training.mode=full_batch").training.mode, TrainingMode::kFullBatch);
  EXPECT_EQ(overridden("training.noise=uniform:3").training.noise.of(0).scale, 3.0);
  EXPECT_FALSE(overridden("observer.learn_eigenvalues=false").observer.learn_eigenvalues);
}

TEST(Override, TheLastOneWins) {
  EXPECT_EQ(parse_experiment(kPlantExperiment, "e", {"training.steps=2", "training.steps=3"}).training.steps, 3);
}

TEST(Override, IsPartOfTheRecordedText) {
  const Experiment e = overridden("training.steps=25");
  EXPECT_EQ(parse_experiment(e.source_text, "s").training.steps, 25);
}

TEST(Override, ErrorsNameIt) {
  const auto error = [](const std::string& assignment) { return error_of(kPlantExperiment, {assignment}); };
  EXPECT_THAT(error("training.stepz=3"),
              StartsWith("--set training.stepz=3: unknown key \"stepz\" in [training]; did you mean \"steps\"?"));
  EXPECT_THAT(error("training.steps=-3"), StartsWith("--set training.steps=-3: [training] steps is -3"));
  EXPECT_THAT(error("training.steps=[1"), StartsWith("--set training.steps=[1: "));
  EXPECT_THAT(error("training.steps="), StartsWith("--set training.steps=: "));
  EXPECT_THAT(error("training.steps"), HasSubstr("no KEY=VALUE"));
  EXPECT_THAT(error("=3"), HasSubstr("no KEY=VALUE"));
  EXPECT_THAT(error("training..steps=3"), HasSubstr("the key is not SECTION.KEY"));
  EXPECT_THAT(error("training.=3"), HasSubstr("the key is not SECTION.KEY"));
  EXPECT_THAT(error("name.x=3"), HasSubstr("\"name\" is not a section"));
  EXPECT_THAT(error("training.steps=1\nseed=2"), HasSubstr("more than one line"));
  EXPECT_THAT(error("training=3"), HasSubstr("it must be a section: [training]"));
  EXPECT_THAT(error("observer.hold=rk5"),
              StartsWith("--set observer.hold=rk5: [observer] hold is \"rk5\"; use \"rk4\"?"));
}

}  // namespace
}  // namespace nlo::trainer
