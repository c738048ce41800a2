// SPDX-License-Identifier: MIT
// An observer of a simulated plant f(x, u) that is trained on drawn inputs uses its inputs in flight.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/training/training_testing.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/learn/training/train.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {
namespace {

Experiment integrator(bool excited, const std::vector<std::string>& changes = {}) {
  // Without u, x2 follows from y only after the delay of a filtered derivative; with u, the estimate moves at once.
  Experiment experiment = parse_experiment(
      std::string("name = \"pushed_mass\"\n[plant]\nstates = [\"x1\", \"x2\"]\ninputs = [\"u\"]\n"
                  "derivative = [\"x2\", \"-x1 - 0.4 * x2 + u + 0.1 * u ^ 3\"]\noutputs = [\"x1\"]\n") +
          (excited
               ? "[excitation]\nkinds = [\"steps\"]\nlow = [-1.5]\nhigh = [1.5]\nshortest_s = 0.2\nlongest_s = 2.0\n"
               : "") +
          "[simulation]\nhorizon_s = 15.0\nsample_period_s = 0.05\ntrajectories = 12\ninitial_low = [-1.0, -1.0]\n"
          "initial_high = [1.0, 1.0]\n[observer]\neigenvalues = [-2.0, -3.0, -5.0]\nlearn_eigenvalues = false\n"
          "features = \"latent_and_output\"\n[inverse_map]\nhidden = [12]\nlinear_path = true\nridge = "
          "1e-9\n[training]\n"
          "steps = 300\nlearning_rate = 3e-3\ntrajectories_per_step = 8\nsamples_per_step = 400\n",
      "pushed_mass.toml", changes);
  experiment.threads = 1;
  return experiment;
}

double settled_error(const codegen::Model& model, const Dataset& data) {
  return testing::settled_rmse(model, data, 200);
}

TEST(ExcitedTraining, AnObserverTrainedWithExcitationUsesItsInputs) {
  const std::vector<std::string> by_settled = {"inverse_map.readout=\"settled\""};
  const TrainingSets sets = simulate_training_sets(integrator(true));
  ASSERT_TRUE(sets.training.reads_inputs);
  const codegen::Model with = train(integrator(true, by_settled), sets.training, sets.validation, {}).model;
  ASSERT_EQ(with.nu(), 1);
  EXPECT_EQ(with.inputs[0].name, "u");
  EXPECT_GE(with.input_max(0), 1.5);
  const codegen::Model without =
      train(integrator(false, by_settled), simulate_training_sets(integrator(false)).training, sets.validation, {})
          .model;
  EXPECT_EQ(without.nu(), 0);
  EXPECT_LT(settled_error(with, sets.validation), 0.1 * settled_error(without, sets.validation));
}

TEST(ExcitedTraining, AMirroredRunChangesTheSignsOfItsInputs) {
  const auto mirror_of = [](std::vector<std::string> changes) {
    changes.emplace_back("training.mirror=true");
    const TrainingData data(simulate_training_sets(integrator(true, changes)).training);
    return Eigen::Vector2d(static_cast<double>(data.mirror.of_reading(0)),
                           static_cast<double>(data.mirror.of_reading(1)));
  };
  EXPECT_EQ(mirror_of({}), Eigen::Vector2d(-1.0, -1.0));
  EXPECT_EQ(mirror_of({"plant.derivative=[\"x2\", \"-x1 - u^2 * x2\"]", "plant.even=[\"u\"]"}),
            Eigen::Vector2d(-1.0, 1.0));
  EXPECT_ANY_THROW(mirror_of({"plant.derivative=[\"x2\", \"-x1 - x2 + u^2\"]"})) << "the plant is not odd in u";
}

TEST(ExcitedTraining, MirrorLearnsTheEffectOfInputs) {
  const auto trained = [](const Experiment& experiment) {
    const TrainingSets sets = simulate_training_sets(experiment);
    return train(experiment, sets.training, sets.validation, {}).model;
  };
  const codegen::Model model = trained(integrator(true, {"training.mirror=true", "excitation.low=[0]"}));
  const codegen::Model plain = trained(integrator(true, {"excitation.low=[0]"}));
  // Trained only on u >= 0 and tested where u < 0: the mirror images cover that range.
  const Dataset other = simulate_training_sets(integrator(true, {"excitation.high=[0]"})).validation;
  EXPECT_LT(settled_error(model, other), 0.7 * settled_error(plain, other));
}

}  // namespace
}  // namespace nlo::trainer
