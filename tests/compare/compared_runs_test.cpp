// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/compared_runs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/compare/plants.h"
#include "tests/support/thrown_message.h"
#include "trainer/judge/compare/conditions.h"
#include "trainer/judge/compare/study.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::VectorXd;
using testing::HasSubstr;
using testing::StartsWith;

ComparedRuns runs_under(const Condition& condition) {
  return compared_runs(test::van_der_pol(), condition, SeedStream::kTest, 3, 2, 4);
}

const MatrixXd& truth(const ComparedRuns& runs, std::size_t i) {
  return runs.set.trajectories[i].states;
}

/// RMS of the measurements' errors.
double error_rms(const ComparedRuns& runs) {
  double sum = 0.0, count = 0.0;
  for (std::size_t i = 0; i < runs.outputs.size(); ++i) {
    const MatrixXd error = runs.outputs[i] - runs.set.trajectories[i].outputs;
    for (const double e : error.reshaped())
      if (!std::isnan(e)) {
        sum += e * e;
        count += 1.0;
      }
  }
  return std::sqrt(sum / count);
}

TEST(ComparedRuns, DifferOnlyByTheCondition) {
  const ComparedRuns plain = runs_under({});
  ASSERT_EQ(plain.outputs.size(), 8u);
  EXPECT_EQ(error_rms(plain), 0.0);

  Condition noise;
  noise.noise = parse_noise("gaussian:0.5");
  const ComparedRuns noisy = runs_under(noise);
  EXPECT_NEAR(error_rms(noisy), 0.5, 0.05);
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(truth(noisy, i), truth(plain, i));

  Condition parameters;
  parameters.parameter_factor = 1.2;
  const ComparedRuns changed = runs_under(parameters);
  EXPECT_EQ(truth(changed, 5).col(0), truth(plain, 5).col(0));
  EXPECT_GT((truth(changed, 5) - truth(plain, 5)).norm(), 0.1);
  Condition named;
  named.parameters = {{"mu", 1.2}};
  EXPECT_EQ(truth(runs_under(named), 5), truth(changed, 5)) << "the factor and the value give the same parameter";

  Condition process;
  process.process_noise = {0.1, 0.1};
  EXPECT_EQ(truth(runs_under(process), 1).col(0), truth(plain, 1).col(0));
  EXPECT_GT((truth(runs_under(process), 1) - truth(plain, 1)).norm(), 0.1);

  Experiment shared = test::van_der_pol();
  shared.simulation.process_noise = {0.2, 0.2};
  shared.simulation.process_noise_share = 0.0;
  EXPECT_EQ(truth(compared_runs(nominal_experiment(shared), process, SeedStream::kTest, 3, 2, 4), 1),
            truth(runs_under(process), 1))
      << "a condition has its process noise in all runs, whatever their share in training";

  Condition box;
  box.box_scale = 2.0;
  EXPECT_LE((truth(runs_under(box), 7).col(0) - 2.0 * truth(plain, 7).col(0)).norm(), 1e-12);
}

TEST(ComparedRuns, ChangeOneParameterInEachRunSoThatChangesCannotCancel) {
  const Experiment pendulum = nominal_experiment(parse_experiment(
      "name = \"pendulum\"\n[plant]\nstates = [\"angle\", \"rate\"]\nderivative = [\"rate\", \"-g / l * "
      "sin(angle)\"]\noutput_names = [\"y\"]\noutputs = [\"angle\"]\nparameters = { g = 9.81, l = 0.5 }\n[simulation]\n"
      "horizon_s = 2.0\ninitial_low = [-1.0, -1.0]\ninitial_high = [1.0, 1.0]\n[observer]\neigenvalues = [-1.0, "
      "-2.0]\n",
      "pendulum.toml"));
  Condition condition;
  condition.parameter_factor = 1.2;
  const ComparedRuns plain = compared_runs(pendulum, {}, SeedStream::kTest, 1, 2, 3),
                     changed = compared_runs(pendulum, condition, SeedStream::kTest, 1, 2, 3);
  for (std::size_t run = 0; run < 6; ++run) {
    EXPECT_EQ(truth(changed, run).col(0), truth(plain, run).col(0));
    EXPECT_GT((truth(changed, run) - truth(plain, run)).norm(), 0.1) << run;
    const PlantParameters own = experiment_under(pendulum, condition, run).plant->parameters;
    EXPECT_EQ(own[run % 2].second, 1.2 * pendulum.plant->parameters[run % 2].second);
    EXPECT_EQ(own[1 - run % 2].second, pendulum.plant->parameters[1 - run % 2].second);
  }
}

TEST(ComparedRuns, GiveFiltersTheMeasurementsOfTheSensors) {
  Condition condition;
  condition.noise = parse_noise("gaussian:0.5+missing:0.3");
  const ComparedRuns runs = runs_under(condition);
  int missing = 0;
  for (Eigen::Index k = 0; k < runs.measured.samples(); ++k)
    for (Eigen::Index lane = 0; lane < 8; ++lane) {
      const double y = runs.outputs[static_cast<std::size_t>(lane)](0, k);
      const double own = runs.measured.outputs[static_cast<std::size_t>(k)](0, lane);
      EXPECT_TRUE(y == own || (std::isnan(y) && std::isnan(own)));
      missing += std::isnan(own) ? 1 : 0;
    }
  EXPECT_NEAR(missing / (8.0 * 201.0), 0.3, 0.05);
}

TEST(ComparedRuns, AssignTheErrorOfEachLaneToItsRun) {
  const ComparedRuns runs = runs_under({});
  class Still final : public LaneFilter {
   public:
    MatrixXd step(const LaneRuns& lanes, Eigen::Index) override { return MatrixXd::Constant(2, lanes.lanes(), 0.25); }
  } still;
  const LaneRuns twice = repeated(runs.measured, 2);
  const Eigen::ArrayXd squares = squared_errors(still, twice, runs);
  for (Eigen::Index lane = 0; lane < 16; ++lane) {
    const auto run = static_cast<std::size_t>(lane % 8);
    const MatrixXd estimate = MatrixXd::Constant(2, 201, 0.25);
    EXPECT_NEAR(squares[lane], squared_error(runs, run, estimate), 1e-12);
    EXPECT_NEAR(squares[lane], (truth(runs, run) - estimate).colwise().squaredNorm().mean(), 1e-12);
  }
}

TEST(ComparedRuns, AssignTheEstimatesOfEachLaneToItsRun) {
  const ComparedRuns runs = runs_under({});
  class Echo final : public LaneFilter {
   public:
    MatrixXd step(const LaneRuns& lanes, Eigen::Index k) override {
      return lanes.outputs[static_cast<std::size_t>(k)].replicate(2, 1);
    }
  } echo;
  const std::vector<MatrixXd> x_hat = lane_estimates(echo, runs);
  for (std::size_t run = 0; run < x_hat.size(); ++run)
    EXPECT_EQ(x_hat[run], MatrixXd(runs.outputs[run].replicate(2, 1))) << run;
  EXPECT_EQ(set_of(runs, 1, 4).trajectories[2].states, truth(runs, 6)) << "the second set comes from the second seed";
}

const VectorXd kOutput = VectorXd::Constant(1, 1.41);
const VectorXd kStates = Vector2d(1.41, 1.4);
const VectorXd kNoise = VectorXd::Constant(1, 0.5);

std::string refusal(const std::string& text) {
  return thrown_message([&] {
    std::vector<std::string> left_out;
    (void)conditions_of(parse_conditions(text, "mine.toml"), {{"mu", 1.0}}, {kOutput, kStates, kNoise}, left_out);
  });
}

TEST(Conditions, ErrorsNameTheConditionItsLineAndTheRemedy) {
  struct Case {
    std::string text, message;
  };
  for (const auto& [text, message] : std::vector<Case>{
           {"", "mine.toml: there is no condition"},
           {"condition = []", "mine.toml: there is no condition"},
           {"condition = 3", "mine.toml:1: [[condition]]"},
           {"condition = [3]", "mine.toml:1: condition is an integer"},
           {"[condition]\nname = \"a\"", "mine.toml:1: [[condition]]"},
           {"[[condition]]\nnoise = \"none\"", "mine.toml:1: a condition has no name"},
           {"[[condition]]\nname = \"a b\"", "mine.toml:2: [[condition]] name"},
           {"[[condition]]\nname = \"a\"\nnose = \"none\"",
            "mine.toml:3: unknown key \"nose\" in [[condition]]; did you "
            "mean \"noise\"?"},
           {"noise = \"none\"",
            "mine.toml:1: unknown key \"noise\" in a file of conditions; it belongs in [[condition]]"},
           {"[[condition]]\nname = \"a\"\nnoise = \"gausian:1\"", "mine.toml:3: [[condition]] noise"},
           {"[[condition]]\nname = \"a\"\nnoise = [\"none\", \"none\"]", "is for 2 outputs, but there is 1"},
           {"[[condition]]\nname = \"a\"\nparameter_factor = -1", "mine.toml:3: [[condition]] parameter_factor"},
           {"[[condition]]\nname = \"a\"\nparameters = { mi = 2 }",
            "mine.toml:1: condition \"a\" changes the parameter \"mi\""},
           {"[[condition]]\nname = \"a\"\nparameters = { mu = [1, 2] }", "is a range"},
           {"[[condition]]\nname = \"a\"\nprocess_noise = [1, 2, 3]",
            "has process_noise for 3 states, but the plant has 2"},
           {"[[condition]]\nname = \"a\"\nbox_scale = 0", "mine.toml:3: [[condition]] box_scale"},
           {"[[condition]]\nname = \"a\"\n[[condition]]\nname = \"a\"", "mine.toml:3: condition \"a\" is given twice"},
           {"[[condition]\nname", "mine.toml:"},
           {std::string(5000, '['), "mine.toml"},
       })
    EXPECT_THAT(refusal(text), HasSubstr(message)) << text;
  EXPECT_EQ(refusal("[[condition]]\nname = \"a\"\nparameters = { mu = 1.2 }\nnoise = \"gaussian:0.5+missing:0.2\""),
            "no error")
      << "control: a valid condition is accepted";
}

TEST(Conditions, AreScaledToThePlantByRoundNumbers) {
  EXPECT_EQ(round_factor(1.01), 1.0);
  EXPECT_EQ(round_factor(0.3), 0.2);
  EXPECT_EQ(round_factor(40.0), 50.0);
  EXPECT_EQ(round_factor(8.0), 10.0);
  EXPECT_EQ(round_factor(0.0), 1.0);
  std::vector<std::string> left_out;
  const auto own = conditions_of(default_conditions(), {{"mu", 1.0}}, {kOutput, kStates, kNoise}, left_out);
  ASSERT_EQ(own.size(), default_conditions().conditions.size());
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_EQ(own[i].noise, default_conditions().conditions[i].noise);
  EXPECT_TRUE(left_out.empty());

  const auto larger =
      conditions_of(default_conditions(), {}, {100.0 * kOutput, Vector2d(141.0, 0.0141), VectorXd::Zero(1)}, left_out);
  EXPECT_EQ(left_out.size(), 5u) << "the conditions that change parameters of the plant";
  const auto named = [&](const std::string& name) {
    return *std::find_if(larger.begin(), larger.end(),
                         [&](const Condition& condition) { return condition.name == name; });
  };
  EXPECT_EQ(format_noise(named("gaussian").noise), "gaussian:50");
  EXPECT_EQ(format_noise(named("mixture").noise), "gaussian:50+outliers:0.05:1000+bias:20+quantised:25+missing:0.2");
  EXPECT_THAT(named("process_noise").process_noise, testing::ElementsAre(10.0, 0.001));
}

TEST(Conditions, ScaleNoiseWithTheSensorsNoiseAndOutliersWithTheOutput) {
  std::vector<std::string> left_out;
  const VectorXd precise = VectorXd::Constant(1, 0.001);
  const auto all = conditions_of(default_conditions(), {{"mu", 1.0}}, {kOutput, kStates, precise}, left_out);
  const auto named = [&](const std::string& name) {
    return *std::ranges::find_if(all, [&](const Condition& condition) { return condition.name == name; });
  };
  EXPECT_EQ(format_noise(named("gaussian").noise), "gaussian:0.001");
  EXPECT_EQ(format_noise(named("outliers").noise), "gaussian:0.001+outliers:0.05:10");
  EXPECT_EQ(format_noise(named("bias").noise), "gaussian:0.001+bias:4e-04");
}

TEST(Conditions, DefaultsAreValidForEveryBuiltInPlant) {
  std::vector<std::string> left_out;
  EXPECT_EQ(compared_conditions(test::van_der_pol(), default_conditions(), left_out).size(), 20u);
}

}  // namespace
}  // namespace nlo::trainer
