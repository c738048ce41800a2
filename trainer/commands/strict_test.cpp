// SPDX-License-Identifier: MIT
#include "trainer/commands/strict_test.h"

#include <fmt/format.h>

#include <memory>

#include "codegen/error.h"
#include "trainer/baselines/ekf.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

EstimatorFactory alternative(const std::string& name, const Experiment& experiment, const Dataset& set,
                             const NoiseConfig& noise) {
  if (name == "constant") return constant_estimator(set);
  if (name != "ekf") throw codegen::Error(fmt::format("no alternative \"{}\"; there are ekf, constant", name));
  const auto& low = experiment.simulation.initial_low;
  const auto& high = experiment.simulation.initial_high;
  const auto n = static_cast<Eigen::Index>(low.size());
  const EkfConfig config = ekf_config(Eigen::VectorXd::Map(low.data(), n), Eigen::VectorXd::Map(high.data(), n), noise);
  return ekf_estimator(
      [plant_config = *experiment.plant] {
        const std::shared_ptr<const Plant> plant = make_plant(plant_config);
        return EkfPlant{[plant](const Eigen::MatrixXd& x) { return plant->derivative(x); },
                        [plant](const Eigen::MatrixXd& x) { return plant->output(x); },
                        [plant](const Eigen::MatrixXd& x, const Eigen::VectorXd& u) {
                          Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(x.rows(), x.cols());
                          for (Eigen::Index j = 0; j < u.size(); ++j) sum += u(j) * plant->input_field(x, j);
                          return sum;
                        }};
      },
      config);
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
  const Dataset set = simulate(*plant, experiment.simulation, initial_state_seed(test.seed, SeedStream::kTest),
                               test.trajectories, test.box_scale, parse_excitation(*plant, test.inputs));
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
