// SPDX-License-Identifier: MIT
// Known inputs in each structure that reads them: roll-outs equal flight, and an observer that knows u estimates states
// that it could not estimate without.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <random>
#include <string>

#include "codegen/model_file/model_file.h"
#include "tests/support/thrown_message.h"
#include "tests/training/training_testing.h"
#include "trainer/data/log_delays.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/train.h"
#include "trainer/structures/structure.h"
#include "trainer/structures/structure_table.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {
namespace {

constexpr double kStep_s = 0.05;

/// x1' = x2, x2' = -x1 - 0.4 x2 + u, y = x1. u changes every six samples and has acted since the sample before.
Dataset pushed_oscillator(bool known, unsigned seed, double horizon_s = 20.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Dataset data;
  data.outputs = {{"y", "m", 0.0}};
  data.states = {{"position", "m", 0.0}, {"velocity", "m/s", 0.0}};
  data.sample_period_s = kStep_s;
  if (known) {
    data.inputs = {{"u", "N", 0.0}};
    data.reads_inputs = true;
  }
  const auto samples = static_cast<Eigen::Index>(std::lround(horizon_s / kStep_s)) + 1;
  for (int r = 0; r < 8; ++r) {
    Trajectory run;
    run.source = "simulation " + std::to_string(r);
    run.time_s = Eigen::VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1) * kStep_s);
    run.states.resize(2, samples);
    run.weight = (run.time_s.array() >= 6.0).cast<double>();  // the transient is not tested here
    Eigen::MatrixXd u(1, samples);
    Eigen::Vector2d x(uniform(random), uniform(random));
    double command = 0.0;
    for (Eigen::Index k = 0; k < samples; ++k) {
      if (k % 6 == 0) command = 2.0 * uniform(random);
      u(0, k) = command;
      constexpr int kPieces = 20;
      for (int i = 0; k > 0 && i < kPieces; ++i) {  // Heun: h^3 with h a twentieth of the period, 1e-9
        const double h = kStep_s / kPieces;
        const auto slope = [&](const Eigen::Vector2d& at) {
          return Eigen::Vector2d(at(1), -at(0) - 0.4 * at(1) + command);
        };
        const Eigen::Vector2d first = slope(x), second = slope(x + h * first);
        x += 0.5 * h * (first + second);
      }
      run.states.col(k) = x;
    }
    run.outputs = run.states.topRows(1);
    if (known) run.inputs = u;
    data.trajectories.push_back(run);
  }
  return data;
}

/// A linear T* on fixed modes, so that a ridge regression is the optimum.
Experiment experiment_of(const std::string& structure) {
  const std::string latent = structure == "luenberger"
                                 ? "state_matrix = [[0.0, 1.0], [-1.0, -0.4]]\noutput_matrix = [[1.0, 0.0]]\n"
                                   "gain_poles = [-2.0, -2.5]\n"
                             : structure == "gated" ? "units = 6\n"
                                                    : "pairs = [[-2.0, 1.5]]\neigenvalues = [-3.0]\n";
  const std::string features =
      structure == "kkl" ? "features = \"latent_and_output\"\nlearn_eigenvalues = false\n" : "";
  Experiment experiment = parse_experiment(
      "name = \"pushed\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\ninitial_low = [-1.0, -1.0]\n"
      "initial_high = [1.0, 1.0]\nsample_period_s = 0.05\n[observer]\nstructure = \"" +
          structure + "\"\n" + latent + features +
          "[dynamics]\nhidden = [4]\n[inverse_map]\nhidden = []\nlinear_path = true\nridge = 1e-10\n[training]\n"
          "steps = 40\nlearning_rate = 1e-3\ntrajectories_per_step = 8\nsamples_per_step = 400\n",
      "pushed.toml");
  experiment.threads = 1;
  if (structure == "luenberger") experiment.observer.own.set<LuenbergerConfig>().input_matrix = {{0.0}, {1.0}};
  return experiment;
}

class EveryStructure : public ::testing::TestWithParam<std::string> {};

TEST_P(EveryStructure, TrainingWithInputsEqualsFlight) {
  const Dataset data = pushed_oscillator(true, 1);
  for (const char* hold : {"zero_order", "first_order"}) {
    Experiment experiment = experiment_of(GetParam());
    experiment.observer.input_hold = hold == std::string("zero_order") ? Hold::kZeroOrder : Hold::kFirstOrder;
    const TrainingResult result = train(experiment, data, data, {});
    ASSERT_EQ(result.model.nu(), 1);
    ASSERT_EQ(result.model.nr(), 2);
    // The validation error comes from the roll-out of the trainer, in float.
    EXPECT_NEAR(result.validation_rmse, testing::reference_rmse(result.model, data),
                2e-3 * result.validation_rmse + 2e-6)
        << hold;
  }
}

TEST_P(EveryStructure, AModelWithInputsReadsBackUnchanged) {
  const Dataset data = pushed_oscillator(true, 1, 10.0);
  const codegen::Model model = train(experiment_of(GetParam()), data, data, {}).model;
  const std::string text = codegen::to_json(model);
  EXPECT_EQ(codegen::to_json(codegen::parse_model(text, "model.json")), text);
}

INSTANTIATE_TEST_SUITE_P(Structures, EveryStructure, ::testing::Values("kkl", "luenberger", "general", "gated"),
                         [](const auto& one) { return one.param; });

TEST(Inputs, EveryStructureUsesInputs) {
  for (const TrainableStructure* structure : structure_table())
    EXPECT_NE(structure->reads_inputs(), structure->flies_inputs()) << structure->name();
}

TEST(Inputs, AKklObserverNeedsUToEstimateADrivenLinearPlant) {
  const Dataset unseen = pushed_oscillator(true, 5);
  const codegen::Model with = train(experiment_of("kkl"), pushed_oscillator(true, 1), unseen, {}).model;
  Dataset blind = pushed_oscillator(false, 5);
  const codegen::Model without = train(experiment_of("kkl"), pushed_oscillator(false, 1), blind, {}).model;
  // With modes of y and of u, x is a linear function of z; the remaining error is the linear interpolation of y.
  EXPECT_LT(testing::reference_rmse(with, unseen), 4e-3);
  EXPECT_GT(testing::reference_rmse(without, blind), 10.0 * testing::reference_rmse(with, unseen));
}

TEST(Inputs, DifferentialEquationsAgreeWithTheExactFilterOnCommands) {
  // With RK4 both have the same coefficients; they differ by float32 rounding of z.
  Experiment experiment = experiment_of("kkl");
  experiment.observer.hold = Hold::kRk4;
  const Dataset data = pushed_oscillator(true, 2, 10.0);
  const ObserverStructure structure = make_structure(experiment, false, data.outputs, data.states, data.inputs);
  const TrainingData training(data);
  ThreadPool pool(1);
  const auto roll_out = [&](LatentGradient gradient) {
    experiment.training.gradient = gradient;
    const auto dynamics = structure.module->latent_dynamics(experiment, structure, training.steps_s, 1);
    dynamics->prepare(initial_dynamics(structure, experiment).data());
    Rollout rollout(training);
    rollout.run(whole_runs(training), *dynamics, {}, 1, Purpose::kValidationNoise, 0, pool);
    return rollout.groups().front().latent;
  };
  const std::vector<float> exact = roll_out(LatentGradient::kAutomatic), general = roll_out(LatentGradient::kBackprop);
  ASSERT_EQ(exact.size(), general.size());
  for (std::size_t i = 0; i < exact.size(); ++i) ASSERT_NEAR(exact[i], general[i], 1e-5F) << i;
}

std::string refused(const std::string& observer, const std::string& loss) {
  return thrown_message([&] {
    parse_experiment(
        "name = \"rig\"\n[log]\nsample_period_s = 0.1\ntrain_files = [\"a.csv\"]\n[[log.columns]]\nname = \"y\"\n"
        "role = \"output\"\n[[log.columns]]\nname = \"u\"\nrole = \"input\"\n[[log.columns]]\nname = \"x\"\nrole = "
        "\"state\"\n"
        "[observer]\neigenvalues = [-1.0]\n" +
            observer + "[loss]\n" + loss,
        "rig.toml");
  });
}

TEST(Inputs, RefusesContradictionsAndNamesTheRemedy) {
  EXPECT_EQ(refused("", ""), "no error") << "control";
  EXPECT_THAT(
      refused("hold = \"zero_order\"\ninput_hold = \"first_order\"\n", ""),
      ::testing::AllOf(::testing::HasSubstr("rig.toml:17"), ::testing::HasSubstr("set hold = \"first_order\"")));
  EXPECT_THAT(refused("", "map_consistency = 1.0\n"), ::testing::HasSubstr("remove the losses of T, or the inputs"));
  EXPECT_THAT(refused("structure = \"driven_kkl\"\n", ""), ::testing::HasSubstr("needs a plant with inputs"));
}

/// Commands that reach the plant 4 samples late: the column of the log, and the inputs with delay_s.
TEST(LateInputs, DeclaringTheirDelayLowersTheError) {
  constexpr double kLate_s = 4.0 * kStep_s;
  Dataset declared = pushed_oscillator(true, 1), as_logged = declared;
  for (std::size_t i = 0; i < declared.trajectories.size(); ++i) {
    // The plant received u; the column has it earlier. The last values stand for commands that were not yet given.
    const Trajectory& run = declared.trajectories[i];
    Eigen::MatrixXd& column = as_logged.trajectories[i].inputs;
    const Eigen::VectorXd reversed = run.inputs.row(0).reverse().transpose();
    column.row(0) = delayed(run.time_s, reversed, kLate_s).reverse().transpose();
    declared.trajectories[i].inputs.row(0) = delayed(run.time_s, column.row(0).transpose(), kLate_s).transpose();
  }
  const Experiment experiment = experiment_of("kkl");
  const double with = testing::reference_rmse(train(experiment, declared, declared, {}).model, declared);
  const double without = testing::reference_rmse(train(experiment, as_logged, as_logged, {}).model, as_logged);
  EXPECT_LT(with, 0.7 * without) << "with delay_s, without it: " << with << ", " << without;
}

}  // namespace
}  // namespace nlo::trainer
