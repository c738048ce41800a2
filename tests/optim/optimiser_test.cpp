// SPDX-License-Identifier: MIT
#include "trainer/learn/optim/optimiser.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "codegen/base/error.h"
#include "tests/support/thrown_message.h"

namespace nlo::trainer {
namespace {

constexpr float kRounding = 2e-6F;  // a few float32 roundings of numbers about 1, per step

TEST(Adam, TakesTheStepsOfItsPaper) {
  constexpr double kRate = 0.05;
  const double gradients[][2] = {{0.3, -2.0}, {-0.1, -1.0}, {0.7, 0.0}, {0.7, 1e-3}};
  double p[2] = {1.0, -0.5};
  double m[2] = {};
  double v[2] = {};
  float actual[2] = {1.0F, -0.5F};
  Optimiser adam("adam", {{2, kRate, 0.0}});
  for (int t = 1; t <= 4; ++t) {
    float g[2];
    const double factor = 1.0 / t;
    for (int i = 0; i < 2; ++i) {
      const double gradient = gradients[t - 1][i];
      g[i] = static_cast<float>(gradient);
      m[i] = 0.9 * m[i] + 0.1 * gradient;
      v[i] = 0.999 * v[i] + 0.001 * gradient * gradient;
      const double m_hat = m[i] / (1.0 - std::pow(0.9, t));
      const double v_hat = v[i] / (1.0 - std::pow(0.999, t));
      p[i] -= kRate * factor * m_hat / (std::sqrt(v_hat) + 1e-8);
    }
    adam.step(actual, g, t - 1, factor);
    for (int i = 0; i < 2; ++i) EXPECT_NEAR(actual[i], static_cast<float>(p[i]), kRounding) << "step " << t;
  }
}

TEST(Adam, FirstStepIsTheRateForAnySizeOfTheGradient) {
  // The first step is rate * g / (|g| + 1e-8): the sign of the gradient.
  for (const float g : {1e-3F, 1.0F, 1e6F, -1e-3F, -1e6F}) {
    float p = 0.0F;
    Optimiser("adam", {{1, 0.01, 0.0}}).step(&p, &g, 0, 1.0);
    EXPECT_NEAR(p, g > 0.0F ? -0.01F : 0.01F, 1e-6F) << g;
  }
}

TEST(Adam, ContinuesFromASavedState) {
  const float g[] = {0.4F, -0.2F, 0.9F};
  const auto run = [&](bool moved) {
    std::vector<float> p{1.0F, 2.0F, 3.0F};
    Optimiser first("adam", {{3, 0.1, 0.01}});
    for (int t = 0; t < 5; ++t) first.step(p.data(), g, t, 1.0);
    Optimiser second("adam", {{3, 0.1, 0.01}});
    second.memory() = first.memory();
    Optimiser& rest = moved ? second : first;
    for (int t = 5; t < 10; ++t) rest.step(p.data(), g, t, 1.0);
    return p;
  };
  EXPECT_EQ(run(true), run(false));
}

TEST(Adam, ConvergesOnAQuadraticOfUnequalCurvatures) {
  float p[] = {3.0F, -4.0F};
  TrainingConfig config;
  config.steps = 2000;
  Optimiser adam("adam", {{2, 0.05, 0.0}});
  for (long t = 0; t < config.steps; ++t) {
    const float g[] = {100.0F * (p[0] - 1.0F), 0.1F * (p[1] - 2.0F)};
    adam.step(p, g, t, schedule_factor(config, t));
  }
  EXPECT_NEAR(p[0], 1.0F, 1e-3F);
  EXPECT_NEAR(p[1], 2.0F, 1e-3F);
}

TEST(GradientDescent, StepsAgainstTheGradient) {
  float p[] = {1.0F, 2.0F};
  const float g[] = {0.5F, -1.0F};
  Optimiser descent("gradient_descent", {{2, 0.1, 0.0}});
  descent.step(p, g, 0, 0.5);
  EXPECT_FLOAT_EQ(p[0], 1.0F - 0.05F * 0.5F);
  EXPECT_FLOAT_EQ(p[1], 2.0F + 0.05F * 1.0F);
  EXPECT_TRUE(descent.memory().empty());
}

TEST(GradientDescent, ConvergesOnAQuadraticAtItsRate) {
  float p = 1.0F;
  Optimiser descent("gradient_descent", {{1, 0.1, 0.0}});
  for (int t = 0; t < 20; ++t) {
    const float g = p;
    descent.step(&p, &g, t, 1.0);
  }
  EXPECT_NEAR(p, static_cast<float>(std::pow(0.9, 20)), kRounding);
}

TEST(Optimiser, DecaysWeightsIndependentlyOfTheGradient) {
  // Decoupled (AdamW): with a zero gradient p shrinks by rate * decay, which L2 in the gradient of Adam would not give.
  for (const std::string& name : optimiser_names()) {
    float p[] = {2.0F, 2.0F};
    const float g[] = {0.0F, 0.0F};
    Optimiser optimiser(name, {{1, 0.1, 0.5}, {1, 0.1, 0.0}});
    optimiser.step(p, g, 0, 0.5);
    EXPECT_FLOAT_EQ(p[0], 2.0F * (1.0F - 0.1F * 0.5F * 0.5F)) << name;
    EXPECT_FLOAT_EQ(p[1], 2.0F) << name << ": a group without decay keeps its values";
  }
}

TEST(Optimiser, GivesEachGroupItsOwnRate) {
  for (const std::string& name : optimiser_names()) {
    float p[] = {0.0F, 0.0F, 0.0F};
    const float g[] = {1.0F, 1.0F, 1.0F};
    Optimiser optimiser(name, {{1, 0.0, 0.0}, {2, 0.25, 0.0}});
    optimiser.step(p, g, 0, 1.0);
    EXPECT_EQ(p[0], 0.0F) << name << ": rate 0 holds a parameter";
    EXPECT_NEAR(p[1], -0.25F, kRounding) << name;
    EXPECT_EQ(p[1], p[2]) << name;
  }
}

TEST(Optimiser, ListsTheKnownNamesIfANameIsUnknown) {
  for (const std::string& name : optimiser_names()) {
    EXPECT_THAT(thrown_message([&] { Optimiser("adamw", {}); }), testing::HasSubstr(name));
  }
}

TEST(Clip, ShortensALongGradientAndKeepsItsDirection) {
  const std::vector<float> given = {3.0F, -4.0F, 12.0F};  // norm 13
  std::vector<float> g = given;
  for (const double largest : {0.0, 13.0, 20.0}) {
    clip(g, largest);
    EXPECT_EQ(g, given) << largest;
  }
  clip(g, 1.3);
  for (std::size_t i = 0; i < g.size(); ++i) EXPECT_NEAR(g[i], 0.1F * given[i], 1e-6F);
  std::vector<float> zero = {0.0F, 0.0F};
  clip(zero, 1.0);
  EXPECT_EQ(zero, std::vector<float>(2, 0.0F));
}

TEST(Schedule, StartsAtOneAndFollowsItsFormula) {
  constexpr double kTolerance = 1e-12;
  TrainingConfig config;
  config.steps = 400;
  config.decay = 0.99;
  for (const std::string& name : schedule_names()) {
    config.schedule = name;
    EXPECT_EQ(schedule_factor(config, 0), 1.0) << name;
  }
  config.schedule = "constant";
  EXPECT_EQ(schedule_factor(config, 399), 1.0);
  config.schedule = "exponential";
  EXPECT_NEAR(schedule_factor(config, 2), 0.9801, kTolerance);
  config.schedule = "cosine";
  EXPECT_NEAR(schedule_factor(config, 100), 0.5 + 0.5 / std::numbers::sqrt2, kTolerance);
  EXPECT_NEAR(schedule_factor(config, 200), 0.5, kTolerance);
  EXPECT_NEAR(schedule_factor(config, 400), 0.0, kTolerance);
  config.schedule = "warm_restarts";  // cycles of 100, 200 and 400 of 700 steps
  config.steps = 700;
  EXPECT_NEAR(schedule_factor(config, 50), 0.5, kTolerance);
  EXPECT_NEAR(schedule_factor(config, 100), 1.0, kTolerance);
  EXPECT_NEAR(schedule_factor(config, 200), 0.5, kTolerance);
  EXPECT_NEAR(schedule_factor(config, 300), 1.0, kTolerance);
  EXPECT_NEAR(schedule_factor(config, 500), 0.5, kTolerance);
  EXPECT_NEAR(schedule_factor(config, 700), 0.0, kTolerance);
  config.schedule = "linear";
  EXPECT_THROW(schedule_factor(config, 0), codegen::Error);
}

}  // namespace
}  // namespace nlo::trainer
