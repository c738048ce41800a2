// SPDX-License-Identifier: MIT
#include "trainer/judge/compare/runs_under.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/base/nearest_name.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/plants/equations_of_plant.h"
#include "trainer/plants/excitation.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {

Experiment changed_experiment(const Experiment& experiment, const std::vector<std::string>& changes) {
  if (changes.empty()) return experiment;
  for (const std::string& change : changes) {
    const std::string key = change.substr(0, change.find('='));
    if (!key.starts_with("plant.") && !key.starts_with("simulation.") && !key.starts_with("excitation.") &&
        !key.starts_with("feedback."))
      throw codegen::Error(
          fmt::format("--set {}: a test can only change plant.KEY, simulation.KEY, excitation.KEY and feedback.KEY, "
                      "because the model is already trained",
                      change));
    const std::string parameter = "plant.parameters.";
    // Built-in plants check their parameters themselves.
    if (!key.starts_with(parameter) || !experiment.plant->model.empty()) continue;
    std::vector<std::string> names;
    for (const auto& known : experiment.plant->parameters) names.push_back(known.first);
    const std::string name = key.substr(parameter.size());
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    const std::string nearest = nearest_name(name, names);
    throw codegen::Error(fmt::format("--set {}: the plant has no parameter \"{}\"; {}", change, name,
                                     names.empty()     ? "it has none; write the numbers of its equations as parameters"
                                     : nearest.empty() ? fmt::format("there are: {}", fmt::join(names, ", "))
                                                       : fmt::format("did you mean \"{}\"?", nearest)));
  }
  // Requirements of the training (mirror images, a past without inputs) do not apply to a test.
  std::vector<std::string> all = changes;
  all.insert(all.end(), {"training.mirror=false", "training.transient=keep"});
  return parse_experiment(experiment.source_text, "the model's experiment", all);
}

Experiment nominal_experiment(const Experiment& experiment) {
  Experiment nominal = experiment;
  nominal.plant->parameter_ranges.clear();
  nominal.simulation.process_noise.clear();
  nominal.simulation.process_noise_share = 1.0;  // a condition with process noise has it in all runs
  if (!nominal.plant->model.empty()) nominal.plant->parameters = equations_of(*nominal.plant).parameters;
  nominal.source_text = format_experiment(nominal);  // changed_experiment() starts from it
  return nominal;
}

Condition trained_condition(const Experiment& experiment, const NoiseConfig& noise) {
  Condition condition;
  condition.name = "as_trained";
  condition.noise = noise;
  condition.process_noise = experiment.simulation.process_noise;
  return condition;
}

Experiment experiment_under(const Experiment& base, const Condition& condition, std::size_t run) {
  Experiment tested = base;
  if (condition.changes_parameters())
    tested.plant->parameters = changed_parameters(condition, base.plant->parameters, run);
  if (!condition.process_noise.empty()) tested.simulation.process_noise = condition.process_noise;
  return tested;
}

Dataset runs_under(const Experiment& base, const Condition& condition, std::uint64_t engine_seed, int count,
                   std::size_t first_run, const LoopEstimators& estimators) {
  const std::size_t turns =
      condition.parameter_factor == 1.0 ? 1 : std::max<std::size_t>(1, base.plant->parameters.size());
  Dataset all;
  for (std::size_t turn = 0; turn < turns; ++turn) {
    const Experiment tested = experiment_under(base, condition, turn);
    const auto plant = make_plant(*tested.plant);
    Dataset set = simulate_runs(tested, *plant, engine_seed, count, condition.box_scale,
                                parse_excitation(*plant, condition.inputs), estimators);
    if (turn == 0) all = set;
    for (std::size_t i = 0; i < set.trajectories.size(); ++i)
      if ((first_run + i) % turns == turn) all.trajectories[i] = std::move(set.trajectories[i]);
  }
  return all;
}

void disturb_inputs(const NoiseConfig& noise, std::uint64_t seed, Dataset& runs) {
  if (noise.none()) return;
  // Changes the seed, so that these random numbers differ from those of the outputs.
  constexpr std::uint64_t kOfInputs = 0x696e70757473ULL;
  for (std::size_t i = 0; i < runs.trajectories.size(); ++i) {
    Eigen::MatrixXd& inputs = runs.trajectories[i].inputs;
    inputs = held(MeasurementNoise(noise, seed ^ kOfInputs, i).on(inputs));
  }
}

bool holds_inputs(const Experiment& base, const Condition& condition) {
  return base.moves_inputs() && condition.inputs.empty() && base.observer.input_hold == Hold::kZeroOrder;
}

std::uint64_t fresh_noise_seed(const Experiment& experiment) {
  return initial_state_seed(experiment.seed, SeedStream::kTraining);
}

Dataset fresh_training_runs(const Experiment& experiment, const NoiseConfig& input_noise) {
  constexpr int kEnough = 100;  // 250,000 samples of the shipped plants for some ten coefficients
  const auto plant = make_plant(*experiment.plant);
  Dataset runs = simulate_runs(experiment, *plant, initial_state_seed(experiment.seed, SeedStream::kTraining),
                               std::min(experiment.simulation.trajectories, kEnough));
  PlantChannels(*experiment.plant, *plant).apply(runs);
  disturb_inputs(input_noise, fresh_noise_seed(experiment), runs);
  return runs;
}

}  // namespace nlo::trainer
