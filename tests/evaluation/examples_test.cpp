// SPDX-License-Identifier: MIT
#include "trainer/judge/evaluation/examples.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "trainer/judge/evaluation/evaluate.h"

namespace nlo::trainer {
namespace {

using testing::ElementsAre;

constexpr Eigen::Index kSamples = 50;

/// Runs of an angle [rad] that wraps and of a speed that is a thousand times as large.
Dataset mixed_set(int runs) {
  Dataset set{{{"angle", "rad", 2.0 * std::numbers::pi}},
              {{"angle", "rad", 2.0 * std::numbers::pi}, {"speed", "rpm", 0.0}},
              0.1,
              true,
              {}};
  for (int i = 0; i < runs; ++i) {
    const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(kSamples, 0.0, 0.1 * (kSamples - 1));
    Eigen::MatrixXd x(2, kSamples);
    x.row(0) = t.transpose().array().sin().matrix();
    x.row(1) = 1000.0 * t.transpose().array().cos().matrix();
    set.trajectories.push_back({"run " + std::to_string(i), t, x.row(0), x, Eigen::VectorXd::Ones(kSamples)});
  }
  return set;
}

std::vector<std::size_t> indices(const std::vector<Chosen>& chosen) {
  std::vector<std::size_t> runs;
  for (const Chosen& each : chosen) runs.push_back(each.run);
  return runs;
}

TEST(RelativeError, ScalesEachStateByItsStandardDeviation) {
  const Dataset set = mixed_set(1);
  const Eigen::VectorXd scale = state_deviation(set);
  EXPECT_NEAR(scale[1] / scale[0], 1000.0, 500.0);
  for (const Eigen::Index state : {0, 1}) {
    Eigen::MatrixXd estimate = set.trajectories[0].states;
    estimate.row(state).array() += scale[state];  // wrong by one standard deviation in one of two states
    EXPECT_NEAR(relative_error(set.trajectories[0], estimate, set.states, scale), std::sqrt(0.5), 1e-12);
  }
}

TEST(RelativeError, MeasuresAnglesTheShortWayAndLeavesOutMaskedSamples) {
  Dataset set = mixed_set(1);
  const Eigen::VectorXd scale = state_deviation(set);
  Eigen::MatrixXd estimate = set.trajectories[0].states;
  estimate.row(0).array() += 2.0 * std::numbers::pi;
  EXPECT_NEAR(relative_error(set.trajectories[0], estimate, set.states, scale), 0.0, 1e-12);
  estimate(1, 3) = 1e6;
  EXPECT_GT(relative_error(set.trajectories[0], estimate, set.states, scale), 1.0);
  set.trajectories[0].weight[3] = 0.0;
  EXPECT_NEAR(relative_error(set.trajectories[0], estimate, set.states, scale), 0.0, 1e-12);
}

TEST(SpreadChoice, KeepsAllRunsIfThereAreFewAndNamesBestAndWorst) {
  const auto chosen = spread_choice({0.3, 0.1, 0.9});
  EXPECT_THAT(indices(chosen), ElementsAre(0, 1, 2));
  EXPECT_EQ(chosen[0].why, "first");
  EXPECT_EQ(chosen[1].why, "best");
  EXPECT_EQ(chosen[2].why, "worst");
  EXPECT_EQ(spread_choice({0.3}).front().why, "first");  // the only run is neither best nor worst
}

TEST(SpreadChoice, ChoosesFirstBestWorstAndEvenlySpreadOnesOfMany) {
  std::vector<double> errors(100, 0.5);
  errors[41] = 0.9;
  errors[42] = 0.1;
  const auto chosen = spread_choice(errors, 8);
  EXPECT_THAT(indices(chosen), ElementsAre(0, 19, 39, 41, 42, 59, 79, 99));
}

TEST(SpreadChoice, NeverChoosesARunTwice) {
  for (std::size_t count = 1; count <= 40; ++count) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < count; ++i) errors.push_back(std::sin(static_cast<double>(7 * i)));
    const auto runs = indices(spread_choice(errors, 8));
    EXPECT_EQ(runs.size(), std::min<std::size_t>(count, 8)) << count;
    EXPECT_TRUE(std::adjacent_find(runs.begin(), runs.end(), std::greater_equal<>()) == runs.end()) << count;
  }
}

TEST(FirstAndWorst, DoNotDependOnTheOrderOfEvaluation) {
  const Dataset set = mixed_set(5);
  const auto examples = [&](std::vector<std::size_t> order) {
    FirstAndWorst kept(set);
    for (const std::size_t i : order) {
      Eigen::MatrixXd estimate = set.trajectories[i].states;
      estimate.row(1).array() += i == 2 || i == 4 ? 700.0 : 10.0;  // two runs are equally bad
      kept.offer(i, set.trajectories[i].outputs, estimate);
    }
    std::string text;
    for (const EvaluatedRun& run : kept.take()) text += run.truth.source + ":" + run.why + " ";
    return text;
  };
  EXPECT_EQ(examples({0, 1, 2, 3, 4}), "run 0:first run 2:worst ");
  EXPECT_EQ(examples({4, 3, 2, 1, 0}), "run 0:first run 2:worst ");
}

TEST(OutsideOfDomain, IsJudgedByTheLatentStateRelativeToTheAngle) {
  // z follows the angle at 10 1/s from its first value. z lags this ramp by at most 0.1 rad, so relative to the angle
  // it stays inside the domain, although z itself reaches 20 rad.
  codegen::Model model;
  model.name = "follower";
  model.outputs = {{"angle", "rad", 2.0 * std::numbers::pi}};
  model.states = {{"rate", "rad/s", 0.0}};
  model.sample_period_s = 0.1;
  codegen::linear_latent(model)->eigenvalues = Eigen::VectorXd::Constant(1, -10.0);
  codegen::linear_latent(model)->output_injection = Eigen::MatrixXd::Constant(1, 1, 10.0);
  model.initial_latent = Eigen::VectorXd::Zero(1);
  codegen::linear_latent(model)->starts_steady = true;
  model.output_min = Eigen::VectorXd::Constant(1, -100.0);
  model.output_max = Eigen::VectorXd::Constant(1, 100.0);
  model.latent_min = Eigen::VectorXd::Constant(1, -0.2);
  model.latent_max = Eigen::VectorXd::Constant(1, 0.2);
  codegen::inverse_map(model)->features = Eigen::RowVector2d(-1.0, 1.0);
  codegen::inverse_map(model)->feature_mean = Eigen::VectorXd::Zero(1);
  codegen::inverse_map(model)->feature_scale = Eigen::VectorXd::Ones(1);
  codegen::inverse_map(model)->layers = {{Eigen::MatrixXd::Constant(1, 1, 10.0), Eigen::VectorXd::Zero(1)}};
  codegen::inverse_map(model)->output_mean = Eigen::VectorXd::Zero(1);
  codegen::inverse_map(model)->output_scale = Eigen::VectorXd::Ones(1);

  EvaluatedRun run;
  run.truth.time_s = Eigen::VectorXd::LinSpaced(201, 0.0, 20.0);
  run.measured = run.truth.time_s.transpose();
  EXPECT_EQ(outside_of_domain(model, run, true).sum(), 0.0);
  run.measured.row(0).tail(100).array() += 1.0;  // a jump that z has not yet followed
  const Eigen::VectorXd outside = outside_of_domain(model, run, true);
  EXPECT_EQ(outside.head(101).sum(), 0.0);
  EXPECT_EQ(outside[101], 1.0);
  EXPECT_EQ(outside[200], 0.0);
}

}  // namespace
}  // namespace nlo::trainer
