// SPDX-License-Identifier: MIT
#include "trainer/experiments/known_plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "codegen/base/error.h"
#include "trainer/base/random.h"
#include "trainer/config/key_error.h"
#include "trainer/data/log_schema.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/experiment_checks.h"
#include "trainer/experiments/training_sets.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_registry.h"

namespace nlo::trainer {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

bool is_same(const Channel& a, const Channel& b) {
  return a.name == b.name && a.unit == b.unit && a.wrap == b.wrap;
}

/// Returns, for each channel of the logs, the row of the same channel in the plant.
std::vector<Index> rows_of(const std::vector<Channel>& logs, const std::vector<Channel>& plant, std::string_view what) {
  std::vector<Index> rows;
  for (const Channel& channel : logs) {
    const auto same = std::ranges::find_if(plant, [&](const Channel& own) { return is_same(own, channel); });
    if (same == plant.end()) {
      const auto named = std::ranges::find(plant, channel.name, &Channel::name);
      throw KeyError("plant", fmt::format("the logs have the {} \"{}\"{}, but [plant] does not; {}", what, channel.name,
                                          channel.unit.empty() ? "" : " in " + channel.unit,
                                          named == plant.end() ? "name its channels as [[log.columns]] does"
                                                               : "units and wraps of both must be the same"));
    }
    rows.push_back(same - plant.begin());
  }
  return rows;
}

std::vector<Channel> measured(const std::vector<Channel>& outputs) {
  return {outputs.begin(), outputs.begin() + codegen::measured_outputs(outputs)};
}

MatrixXd rows(const MatrixXd& of, const std::vector<Index>& chosen) {
  return of(chosen, Eigen::all);
}

/// Returns the experiment on the known plant alone, as if there were no logs.
Experiment on_known_plant(const Experiment& experiment) {
  Experiment alone = experiment;
  alone.plant = experiment.known->plant;
  alone.plant->outputs_read_inputs = experiment.known->simulation.share == 0.0;
  alone.simulation = experiment.known->simulation;
  alone.excitation = experiment.known->excitation;
  alone.known.reset();
  alone.log.reset();
  alone.training.segment_s = 0.0;  // it is meant for logs, which are longer
  return alone;
}

}  // namespace

void check_known_plant(const Experiment& experiment) {
  const Experiment alone = on_known_plant(experiment);
  check_plant_and_simulation(alone);
  check_excitation(alone);
  const double period_s = experiment.log->sample_period_s;
  if (period_s > 0.0 && period_s != alone.simulation.sample_period_s)
    throw KeyError("simulation.sample_period_s",
                   fmt::format("[simulation] sample_period_s is {}, but that of [log] is {}; remove it here",
                               alone.simulation.sample_period_s, period_s));
  const LogSchema schema = resolve_columns(*experiment.log);
  const auto plant = make_plant(*alone.plant);
  const PlantChannels channels(*alone.plant, *plant);
  rows_of(measured(schema.output_channels), channels.outputs(), "output");
  rows_of(schema.state_channels, channels.states(), "state");
  if (alone.simulation.share > 0.0) rows_of(schema.input_channels, plant->inputs(), "input");
}

// With share = 0 only parts such as a prior use the plant's equations.
void add_simulated_runs(const Experiment& experiment, Dataset& logs) {
  if (!experiment.known || experiment.known->simulation.share == 0.0) return;
  Experiment alone = on_known_plant(experiment);
  alone.simulation.sample_period_s = logs.sample_period_s;
  const Dataset simulated = simulate_training_sets(alone).training;
  const std::vector<Index> outputs = rows_of(measured(logs.outputs), simulated.outputs, "output");
  const std::vector<Index> states = rows_of(logs.states, simulated.states, "state");
  const std::vector<Index> inputs = rows_of(logs.inputs, simulated.inputs, "input");
  std::uint64_t number = 0;
  for (const Trajectory& run : simulated.trajectories) {
    Trajectory& own = logs.trajectories.emplace_back(run);
    own.outputs.setZero(static_cast<Index>(logs.outputs.size()), run.samples());
    MeasurementNoise noise(alone.simulation.noise, alone.seed, number++);
    own.outputs.topRows(static_cast<Index>(outputs.size())) = noise.on(rows(run.outputs, outputs), logs.output_angles);
    own.states = rows(run.states, states);
    if (run.inputs.size() > 0) own.inputs = rows(run.inputs, inputs);
  }
  logs.compute_outputs();
  logs.simulated_share = alone.simulation.share;
}

}  // namespace nlo::trainer
