// SPDX-License-Identifier: MIT
// Training with declared symmetries: what it knows of places where no run was, and that the number of threads changes
// no byte.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "codegen/model_file/model_file.h"
#include "codegen/replay/reference_observer.h"
#include "tests/training/testing.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/training/train.h"

namespace nlo::trainer {
namespace {

using testing::reference_rmse;

/// A mass of the plane on a spring that stiffens, seen; how fast it is, is not. `angle`: of where it starts [rad].
Experiment planar(const std::string& symmetry, double angle = 0.0, const std::string& training = "steps = 300\n") {
  const double x = std::cos(angle), y = std::sin(angle);
  Experiment experiment = parse_experiment(
      "name = \"planar\"\n[plant]\nstates = [\"x\", \"y\", \"vx\", \"vy\"]\noutput_names = [\"mx\", \"my\"]\n"
      "derivative = [\"vx\", \"vy\", \"-x * (1 + x^2 + y^2)\", \"-y * (1 + x^2 + y^2)\"]\noutputs = [\"x\", \"y\"]\n"
      "estimated = [\"vx\", \"vy\"]\n[simulation]\nhorizon_s = 5.0\nsample_period_s = 0.05\ntrajectories = 6\n" +
          fmt::format("initial_low = [{0}, {1}, {0}, {1}]\ninitial_high = [{2}, {3}, {2}, {3}]\n", 0.8 * x - 0.2,
                      0.8 * y - 0.2, 0.8 * x + 0.2, 0.8 * y + 0.2) +
          symmetry +
          "[observer]\neigenvalues = [-2.0, -4.0, -8.0]\nlearn_eigenvalues = false\nstart = \"steady\"\n"
          "output_injection = \"unit_gain\"\n[inverse_map]\nhidden = [16]\nlinear_path = true\n"
          "[training]\nlearning_rate = 3e-3\ntrajectories_per_step = 16\nsamples_per_step = 512\n" +
          training,
      "planar.toml");
  experiment.threads = 1;
  return experiment;
}

const std::string kTurns =
    "[[symmetry]]\nkind = \"rotation2\"\nvectors = [[\"x\", \"y\"], [\"vx\", \"vy\"], [\"mx\", \"my\"]]\n";

codegen::Model trained(const Experiment& experiment) {
  const TrainingSets sets = simulate_training_sets(experiment);
  return train(experiment, sets.training, sets.validation, {}).model;
}

TEST(SymmetryTraining, KnowsDirectionsThatNoRunWentInto) {
  const Dataset ahead = simulate_training_sets(planar("")).validation;
  const Dataset aside = simulate_training_sets(planar("", 2.0)).validation;
  const codegen::Model plain = trained(planar("")), turning = trained(planar(kTurns));
  EXPECT_LT(reference_rmse(turning, aside), 0.5 * reference_rmse(plain, aside));
  EXPECT_LT(reference_rmse(turning, aside), 1.5 * reference_rmse(turning, ahead)) << "it is as good in all";
}

TEST(SymmetryTraining, HasTheSameBytesForAnyNumberOfThreads) {
  Experiment experiment = planar(kTurns, 0.0, "steps = 20\nnoise = \"gaussian:0.1\"\n");
  const std::string one = codegen::to_json(trained(experiment));
  experiment.threads = 2;
  EXPECT_EQ(codegen::to_json(trained(experiment)), one);
}

/// An oscillator by a KKL observer whose T* ships as trained.
Experiment oscillator(const std::string& symmetry, const std::string& map = "readout = \"network\"\n") {
  return parse_experiment(
      "name = \"oscillator\"\n[plant]\nmodel = \"van_der_pol\"\n[simulation]\nhorizon_s = 5.0\nsample_period_s = 0.05\n"
      "trajectories = 6\ninitial_low = [0.0, -1.0]\ninitial_high = [1.0, 1.0]\n" +
          symmetry +
          "[observer]\neigenvalues = [-2.0, -4.0]\nfeatures = \"latent_and_output\"\n[inverse_map]\nhidden = [8]\n" +
          map + "[training]\nsteps = 30\nnoise = \"gaussian:0.1\"\n",
      "oscillator.toml");
}

TEST(SymmetryTraining, AKklObserverOfSignsHasAnOddMapByConstruction) {
  const std::string signs =
      "[[symmetry]]\nkind = \"sign\"\nchannels = [\"x1\", \"x2\", \"y\"]\nby_construction = true\n";
  const auto unevenness = [](const Experiment& experiment) {
    const codegen::Model model = trained(experiment);
    codegen::ReferenceObserver<double> observer(model), mirrored(model);
    const Trajectory run = simulate_training_sets(experiment).validation.trajectories.front();
    return (observer.run(run.outputs, {}, run.time_s, true).x_hat +
            mirrored.run(-run.outputs, {}, run.time_s, true).x_hat)
        .cwiseAbs()
        .maxCoeff();
  };
  EXPECT_LT(unevenness(oscillator(signs)), 1e-12) << "to rounding of double";
  EXPECT_GT(unevenness(oscillator("")), 1e-3) << "control";
  const codegen::Model model = trained(oscillator(signs));
  EXPECT_EQ(model.latent_min, -model.latent_max) << "its domain has mirror images, too";
  EXPECT_THROW(oscillator(signs, ""), codegen::Error) << "a readout that is selected has means";
}

TEST(SymmetryTraining, AnUnwrappedAngleShiftsByConstruction) {
  const Experiment experiment = parse_experiment(
      "name = \"rotor\"\n[plant]\nstates = [\"theta\", \"omega\"]\nstate_wraps = [\"2pi\", 0]\nestimated = "
      "[\"omega\"]\n"
      "derivative = [\"omega\", \"-0.5 * omega\"]\noutput_names = [\"angle\"]\noutputs = [\"theta\"]\noutput_wraps = "
      "[\"2pi\"]\n"
      "[simulation]\nhorizon_s = 5.0\nsample_period_s = 0.05\ntrajectories = 6\ninitial_low = [-3.0, -1.0]\n"
      "initial_high = [3.0, 1.0]\n[[symmetry]]\nkind = \"shift\"\nchannels = [\"theta\", \"angle\"]\nby_construction = "
      "true\n"
      "[observer]\neigenvalues = [-2.0, -4.0]\nstart = \"steady\"\noutput_injection = \"unit_gain\"\n"
      "features = \"latent_minus_output\"\n[training]\nsteps = 20\n",
      "rotor.toml");
  const TrainingSets sets = simulate_training_sets(experiment);
  EXPECT_TRUE(sets.training.symmetries.empty());
  const codegen::Model model = train(experiment, sets.training, sets.validation, {}).model;
  codegen::ReferenceObserver<double> observer(model), shifted(model);
  const Trajectory& run = sets.validation.trajectories.front();
  const Eigen::MatrixXd x_hat = observer.run(run.outputs, {}, run.time_s, true).x_hat;
  const Eigen::MatrixXd image = shifted.run(run.outputs.array() + 1.0, {}, run.time_s, true).x_hat;
  EXPECT_LT((image - x_hat).cwiseAbs().maxCoeff(), 1e-9) << "to rounding of double";
}

}  // namespace
}  // namespace nlo::trainer
