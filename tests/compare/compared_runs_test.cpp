// SPDX-License-Identifier: MIT
#include "trainer/compare/compared_runs.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/compare/plants.h"

namespace nlo::trainer {
namespace {

using Eigen::MatrixXd;

ComparedRuns runs_under(const Condition& condition) {
  return compared_runs(test::van_der_pol(), condition, SeedStream::kTest, 3, 2, 4);
}

const MatrixXd& truth(const ComparedRuns& runs, std::size_t i) {
  return runs.set.trajectories[i].states;
}

/// Of what was measured from what there was.
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

TEST(ComparedRuns, AreTheSameButForWhatTheConditionChanges) {
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
  EXPECT_EQ(truth(runs_under(named), 5), truth(changed, 5)) << "the factor and the value say the same";

  Condition process;
  process.process_noise = {0.1, 0.1};
  EXPECT_EQ(truth(runs_under(process), 1).col(0), truth(plain, 1).col(0));
  EXPECT_GT((truth(runs_under(process), 1) - truth(plain, 1)).norm(), 0.1);

  Condition box;
  box.box_scale = 2.0;
  EXPECT_LE((truth(runs_under(box), 7).col(0) - 2.0 * truth(plain, 7).col(0)).norm(), 1e-12);
}

TEST(ComparedRuns, ChangeOneParameterAtATimeSoThatNoneCancels) {
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

TEST(ComparedRuns, GiveFiltersWhatTheSensorsGave) {
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

TEST(ComparedRuns, CountTheErrorOfALaneAsThatOfItsRun) {
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

}  // namespace
}  // namespace nlo::trainer
