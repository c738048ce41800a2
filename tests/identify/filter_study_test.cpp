// SPDX-License-Identifier: MIT
#include "trainer/identify/filter_study.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "codegen/base/error.h"
#include "tests/identify/identified_pendulum.h"
#include "trainer/data/log_schema.h"
#include "trainer/experiments/load_identification.h"
#include "trainer/identify/identified_filter.h"

namespace nlo::trainer {
namespace {

using Eigen::VectorXd;
using test::pendulum_identification;
using test::pendulum_logs;

FilterStudy study_of(const Identification& identification, double w2) {
  LogSplits splits;
  splits.train = pendulum_logs(11, 3);
  splits.validation = pendulum_logs(12, 2);
  splits.test = pendulum_logs(13, 3);
  ThreadPool pool(2);
  return study_filters(identification, Eigen::Vector2d(w2, test::kDamping), splits, resolve_columns(identification.log),
                       pool);
}

const std::vector<double>& rmse_by_window(const FilterStudy& study, const std::string& estimator) {
  const auto found = std::find_if(study.entries.begin(), study.entries.end(),
                                  [&](const LogEntry& entry) { return entry.estimator == estimator; });
  return found->metrics.pooled.front().rmse;
}

double rmse(const FilterStudy& study, const std::string& estimator) {
  return rmse_by_window(study, estimator).front();
}

double settled_rmse(const FilterStudy& study, const std::string& estimator) {
  return rmse_by_window(study, estimator).back();
}

TEST(FilterStudy, FiltersWithThePlantBeatEstimatorsWithoutIt) {
  const FilterStudy study = study_of(pendulum_identification(), test::kSquare);
  EXPECT_EQ(study.tuned_on, "the validation logs");
  EXPECT_LT(rmse(study, "ekf"), 0.12);  // of a rate of about 4 rad/s; the error comes mostly from the first samples
  EXPECT_NEAR(rmse(study, "ukf") / rmse(study, "ekf"), 1.0, 0.2);
  for (const char* other : {"static_ridge", "constant"})
    EXPECT_GT(rmse(study, other), 3.0 * rmse(study, "ekf")) << other;
  EXPECT_GT(rmse(study_of(pendulum_identification(), 2.0 * test::kSquare), "ekf"), 1.3 * rmse(study, "ekf"))
      << "control: a wrong parameter increases the error";
}

TEST(FilterStudy, StartsAtTheGivenTimes) {
  Identification identification = pendulum_identification({"identify.from_s=[0.0, 1.0]"});
  const FilterStudy study = study_of(identification, test::kSquare);
  EXPECT_EQ(study.entries.front().metrics.files.size(), 6u) << "three logs, twice each";
  EXPECT_EQ(study_of(pendulum_identification(), test::kSquare).entries.front().metrics.files.size(), 3u);
}

/// The rate is measured; the initial angle may be anywhere, which the initial deviation declares.
Identification identification_of_hidden_angle(double initial_deviation) {
  std::string text = test::kPendulumIdentification;
  const auto replace = [&](const std::string& old, const std::string& by) {
    text.replace(text.find(old), old.size(), by);
  };
  replace("output_names = [\"angle\"]\noutputs = [\"angle\"]", "output_names = [\"rate\"]\noutputs = [\"rate\"]");
  replace("noise = { angle = 0.01", "noise = { rate = 0.1");
  replace("initial_state = [0.0, 0.0]", "initial_state = [3.5, 0.0]");
  replace("initial_deviation = [1.0", fmt::format("initial_deviation = [{}", initial_deviation));
  replace("role = \"output\"\nwrap", "role = \"state\"\nwrap");
  replace("name = \"rate\"\nrole = \"state\"", "name = \"rate\"\nrole = \"output\"");
  return parse_identification(text, "hidden.toml", {"evaluation.windows=[{ name = \"settled\", from_s = 1.0 }]"});
}

FilterStudy study_of_hidden_angle(double initial_deviation) {
  const Identification identification = identification_of_hidden_angle(initial_deviation);
  LogSplits splits;
  std::mt19937_64 engine(5);
  int runs = 0;
  std::normal_distribution<double> normal;
  for (const auto& [split, seed] : {std::pair{&splits.train, 11U}, std::pair{&splits.test, 13U}}) {
    *split = test::pendulum_logs(seed, 3);
    std::swap(split->outputs, split->states);
    for (Trajectory& run : split->trajectories) {
      std::swap(run.outputs, run.states);
      const double sign = ++runs % 2 == 0 ? -1.0 : 1.0;  // the mirror image is also a run of the same plant
      for (Eigen::MatrixXd* channels : {&run.outputs, &run.states, &run.inputs}) *channels *= sign;
      for (double& rate : run.outputs.reshaped()) rate += 0.1 * normal(engine);
    }
  }
  ThreadPool pool(2);
  return study_filters(identification, Eigen::Vector2d(test::kSquare, test::kDamping), splits,
                       resolve_columns(identification.log), pool);
}

constexpr double kAnywhere = 1.8137993642;  // 2 pi / sqrt(12), standard deviation of a uniform angle

TEST(FilterStudy, AnAngleIsHiddenIfNoOutputMeasuresItAndItMayStartAnywhere) {
  const auto hidden = [](const Identification& identification) {
    return hidden_angles(identification, resolve_columns(identification.log).state_channels);
  };
  const auto found = hidden(identification_of_hidden_angle(1.001 * kAnywhere));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].state, 0);
  EXPECT_TRUE(hidden(identification_of_hidden_angle(0.999 * kAnywhere)).empty());
  EXPECT_TRUE(hidden(pendulum_identification({"identify.initial_deviation=[9.0, 1.0]"})).empty()) << "it is measured";
}

TEST(FilterStudy, FindsAHiddenAngleFromAnyInitialValue) {
  const FilterStudy bank = study_of_hidden_angle(1.001 * kAnywhere), one = study_of_hidden_angle(0.999 * kAnywhere);
  for (const char* filter : {"ekf", "ukf"}) {
    EXPECT_LT(settled_rmse(bank, filter), 0.02) << filter << ", measured: .0116 and .0103 rad";
    EXPECT_GT(settled_rmse(one, filter), 2.0 * settled_rmse(bank, filter))
        << filter << ", control: a single filter that starts at 3.5 rad";
  }
  EXPECT_GT(bank.entries.front().cost.operations, 16.0 * one.entries.front().cost.operations);
}

TEST(CoordinateSearch, FindsTheSmallestCostInDecadesAndNeverChoosesNaN) {
  const VectorXd least = Eigen::Vector3d(-2.0, 1.5, 0.25);
  const CostsOf costs = [&](const std::vector<VectorXd>& points) {
    std::vector<double> result;
    for (const VectorXd& x : points) result.push_back(x[2] < -0.4 ? std::nan("") : 1.0 + (x - least).squaredNorm());
    return result;
  };
  const Tuned tuned = coordinate_search(VectorXd::Zero(3), costs);
  EXPECT_LT((tuned.x - least).cwiseAbs().maxCoeff(), 0.126);
  EXPECT_LT(tuned.evaluations, 100);
  EXPECT_GT((coordinate_search(VectorXd::Zero(3), costs, true).x - least).norm(), -1.0);
  const std::atomic<bool> stop{true};
  EXPECT_EQ(coordinate_search(VectorXd::Zero(3), costs, false, &stop).evaluations, 1);
}

TEST(StepCost, CountsOperatorsAndCalls) {
  const auto cost = [](const char* text) {
    const StepCost c = cost_of_expression(text);
    return std::pair{c.operations, c.functions};
  };
  EXPECT_EQ(cost("a"), std::pair(0.0, 0.0));
  EXPECT_EQ(cost("-a + b * 2.5"), std::pair(2.0, 0.0)) << "a sign is not counted as an operation";
  EXPECT_EQ(cost("(a + b) / (-c)"), std::pair(2.0, 0.0));
  EXPECT_EQ(cost("sin(a) - tanh (b / 1e-3)"), std::pair(2.0, 2.0));
  EXPECT_EQ(cost("a^2 + b^3 + c^2.5"), std::pair(5.0, 1.0));
  EXPECT_EQ(cost("a <= b ? c : d"), std::pair(2.0, 0.0));
}

TEST(StepCost, GrowsWithTheStepsOfASample) {
  const auto cost = [](PointSet kind, const std::vector<std::string>& overrides) {
    const Identification identification = pendulum_identification(overrides);
    return IdentifiedFilter(identification, {}, pendulum_logs(1)).step_cost(kind, 0.02);
  };
  const StepCost one = cost(PointSet::kExtended, {});
  const StepCost two = cost(PointSet::kExtended, {"identify.longest_step_s=0.01"});
  // 2 n_x + 1 = 5 points; 4 stages with 4 operations and a sine each; 26 operations to combine the stages.
  EXPECT_NEAR(two.operations - one.operations, 5.0 * (4.0 * 4.0 + 26.0), 1e-9);
  EXPECT_EQ(one.functions, 5.0 * 4.0 + 3.0) << "also the roots of two pivots and of the update of one output";
  EXPECT_GT(cost(PointSet::kUnscented, {}).operations, one.operations) << "more columns to triangularise";
}

struct Mistake {
  const char *old, *replacement, *message;
};

class MistakenIdentification : public testing::TestWithParam<Mistake> {};

TEST_P(MistakenIdentification, IsRefusedWithPlaceAndRemedy) {
  const auto& [old, replacement, message] = GetParam();
  std::string text = test::kPendulumIdentification;
  const auto at = text.find(old);
  ASSERT_NE(at, std::string::npos) << old;
  text.replace(at, std::string(old).size(), replacement);
  EXPECT_THAT([&] { parse_identification(text, "f.toml"); },
              testing::ThrowsMessage<codegen::Error>(testing::HasSubstr(message)));
}

INSTANTIATE_TEST_SUITE_P(
    Mistakes, MistakenIdentification,
    testing::Values(
        Mistake{"w2 * sin", "w3 * sin",
                "f.toml:6: [plant] derivative[1] \"-w3 * sin(angle) - c * rate + u\": Unexpected token \"w3\""},
        Mistake{"c = 1.0", "c = 1.0, d = 2.0", "f.toml:9: [plant] the parameter \"d\" has no effect"},
        Mistake{"c * rate + u", "c * rate", "f.toml:5: [plant] the input \"u\" has no effect"},
        Mistake{"positive = [\"w2\"]", "positive = [\"w\"]",
                "[identify] positive \"w\" is not a parameter of the plant; did you mean \"w2\"?"},
        Mistake{"noise = { angle", "noise = { angel",
                "neither an output of the plant nor a logged state; did you mean \"angle\"?"},
        Mistake{"noise = { angle = 0.01 }", "noise = { rate = 0.1 }", "does not have the output \"angle\""},
        Mistake{"noise = { angle = 0.01", "noise = { angle = 0.0", "[identify] noise.angle"},
        Mistake{"output_names = [\"angle\"]", "output_names = [\"angl\"]",
                "[plant] output \"angl\" is not a column of the logs with role \"output\"; did you mean \"angle\"?"},
        Mistake{"name = \"rate\"", "name = \"speed\"", "[[log.columns]] state \"speed\" is not a state of the plant"},
        Mistake{"initial_deviation = [1.0, 5.0]", "initial_deviation = [1.0]",
                "f.toml:15: [identify] initial_deviation has 1 numbers; the plant has 2 states"},
        Mistake{"segment_s", "segments_s", "unknown key \"segments_s\" in [identify]; did you mean \"segment_s\"?"},
        Mistake{"outputs = [\"angle\"]\n", "outputs = [\"angle\"]\nstate_wraps = [\"2pi\", 0]\n",
                "[plant] state_wraps has no effect here"},
        Mistake{"w2 = 15.0", "w2 = -15.0", "[identify] positive keeps it above 0"},
        Mistake{"[identify]", "[observer]",
                "unknown key \"observer\" in the identification; there are: name, threads, plant, log, identify"}));

TEST(Identification, TextWithoutMistakesIsAccepted) {
  const Identification pendulum = test::pendulum_identification();  // the control for all mistakes
  EXPECT_EQ(pendulum.plant.parameters.size(), 2u);
  EXPECT_EQ(pendulum.identify.segment_s, 2.0);
  EXPECT_EQ(test::pendulum_identification({"identify.segment_s=0.5"}).identify.segment_s, 0.5);
}

TEST(Identification, NeedsItsSections) {
  const std::string text = test::kPendulumIdentification;
  EXPECT_THAT([&] { parse_identification(text.substr(0, text.find("[identify]")), "f.toml"); },
              testing::ThrowsMessage<codegen::Error>(testing::HasSubstr("there is no [log]")));
}

TEST(Identification, EveryShippedIdentificationIsValid) {
  EXPECT_GE(shipped_identifications().size(), 6u);
  for (const ShippedExperiment& shipped : shipped_identifications())
    EXPECT_EQ(parse_identification(shipped.text, std::string(shipped.name)).name, shipped.name);
}

}  // namespace
}  // namespace nlo::trainer
