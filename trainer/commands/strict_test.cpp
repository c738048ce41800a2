// SPDX-License-Identifier: MIT
#include "trainer/commands/strict_test.h"

#include <fmt/format.h>

#include <memory>

#include "codegen/error.h"
#include "trainer/analysis/measurement_noise.h"
#include "trainer/baselines/ekf.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

Eigen::VectorXd wraps_of(const std::vector<Channel>& outputs) {
  Eigen::VectorXd wraps(static_cast<Eigen::Index>(outputs.size()));
  for (std::size_t j = 0; j < outputs.size(); ++j) wraps(static_cast<Eigen::Index>(j)) = outputs[j].wrap;
  return wraps;
}

EstimatorFactory alternative(const std::string& name, const Experiment& experiment, const Dataset& set,
                             const NoiseConfig& noise) {
  if (name == "constant") return constant_estimator(set);
  if (name != "ekf") throw codegen::Error(fmt::format("no alternative \"{}\"; there are ekf, constant", name));
  const InitialMoments start = initial_moments(experiment.simulation);
  const EkfConfig config{start.mean, start.covariance, 1e-6, noise_variances(noise)};
  const EstimatorFactory filter = ekf_estimator(
      [plant_config = *experiment.plant] {
        const std::shared_ptr<const Plant> plant = make_plant(plant_config);
        return EkfPlant{[plant](const Eigen::MatrixXd& x) { return plant->derivative(x); },
                        [plant](const Eigen::MatrixXd& x) { return plant->output(x); },
                        [plant](const Eigen::MatrixXd& x, const Eigen::VectorXd& u) {
                          Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(x.rows(), x.cols());
                          for (Eigen::Index j = 0; j < u.size(); ++j) sum += u(j) * plant->input_field(x, j);
                          return sum;
                        },
                        wraps_of(plant->outputs())};
      },
      config);
  const PlantChannels channels(*experiment.plant, *make_plant(*experiment.plant));
  if (channels.plain()) return filter;
  return [filter, channels]() -> Estimator {
    return [ekf = filter(), channels](const Eigen::MatrixXd& outputs, const Eigen::MatrixXd& inputs,
                                      const Eigen::VectorXd& time_s) {
      return channels.states(ekf(channels.plant_outputs(outputs), inputs, time_s));
    };
  };
}

}  // namespace

Experiment experiment_of(const codegen::Model& model, const std::string& origin) {
  for (const auto& [key, text] : model.provenance)
    if (key == "config") return parse_experiment(text, origin + " (provenance.config)");
  throw codegen::Error(
      fmt::format("{}: has no provenance \"config\", so plant and columns are not known; train it again", origin));
}

std::vector<std::vector<Evaluation>> run_strict_test(const codegen::Model& model, const Experiment& experiment,
                                                     const StrictTest& test) {
  const auto plant = make_plant(*experiment.plant);
  Dataset set = simulate(*plant, experiment.simulation, initial_state_seed(test.seed, SeedStream::kTest),
                         test.trajectories, test.box_scale, parse_excitation(*plant, test.inputs));
  PlantChannels(*experiment.plant, *plant).apply(set);
  std::vector<std::vector<Evaluation>> result;
  for (const NoiseConfig& noise : test.noises) {
    auto& group = result.emplace_back();
    group.push_back(evaluate_on_plant(model, set, noise, test.seed, test.threads));
    for (const std::string& name : test.against)
      group.push_back(evaluate(name, alternative(name, experiment, set, noise), set, noise, test.seed, test.threads));
    for (Evaluation& evaluation : group) evaluation.excitation = name_expressions(*plant, test.inputs);
  }
  return result;
}

}  // namespace nlo::trainer
