// SPDX-License-Identifier: MIT
#include "trainer/experiments/training_sets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "codegen/base/error.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/experiments/mirrored_channels.h"
#include "trainer/learn/losses/loss_registry.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/lead_in.h"
#include "trainer/plants/loop_estimator.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/plant_form.h"
#include "trainer/plants/plant_registry.h"
#include "trainer/plants/run_range.h"
#include "trainer/plants/simulate_runs.h"
#include "trainer/structures/structure_table.h"

namespace nlo::trainer {

namespace {

/// Adds the values that the PDE residual (5) needs: f at the samples, or f and h at points of the box.
void add_equations(Dataset& dataset, const Plant& plant, const Experiment& experiment) {
  const LossConfig& loss = experiment.loss;
  if (loss.collocation == EquationPoints::kData) {
    for (Trajectory& trajectory : dataset.trajectories) trajectory.derivatives = plant.derivative(trajectory.states);
    return;
  }
  SimulationConfig box;
  box.initial_low = loss.collocation_low;
  box.initial_high = loss.collocation_high;
  const Eigen::MatrixXd x =
      draw_initial_states(box, initial_state_seed(experiment.seed, SeedStream::kCollocation), loss.collocation_points);
  dataset.collocation = {x, plant.derivative(x), plant.output(x)};
}

/// Refuses an unwrapped angle to be estimated if it turns over, because no function of z can count turns. It may swing.
void check_swinging(const Dataset& dataset) {
  for (std::size_t i = 0; i < dataset.states.size(); ++i) {
    const Channel& state = dataset.states[i];
    if (state.wrap <= 0.0) continue;
    for (const Trajectory& run : dataset.trajectories) {
      const auto values = run.states.row(static_cast<Eigen::Index>(i));
      if (values.maxCoeff() - values.minCoeff() <= state.wrap) continue;
      throw codegen::Error(
          fmt::format("{}: the state {} makes whole turns, which T* cannot count; give it as sine and cosine, [plant] "
                      "state_encodings, "
                      "leave it out of `estimated`, or start within a smaller range",
                      run.source, state.name));
    }
  }
}

}  // namespace

TrainingSets simulate_training_sets(const Experiment& experiment, const LoopRound& round) {
  const auto plant = make_plant(*experiment.plant);
  const SimulationConfig& config = experiment.simulation;
  std::vector<std::string> warnings;
  const auto set = [&](SeedStream stream, Eigen::Index count) {
    // The random streams of rounds never overlap. Round 0 has the stream of an experiment without a loop.
    const std::uint64_t seed =
        initial_state_seed(experiment.seed, stream) ^ (static_cast<std::uint64_t>(round.round) * 0x9e3779b97f4a7c15ULL);
    const LoopEstimators estimators = round.observer == nullptr
                                          ? nullptr
                                          : with_noise(observer_in_loop(*round.observer, experiment, *plant),
                                                       without_shifts(experiment.training.noise), seed);
    Dataset dataset = simulate_runs(experiment, *plant, seed, count, 1.0, {}, estimators);
    if (stream == SeedStream::kTraining) warnings = range_warnings(dataset, experiment);
    keep_out_transient(experiment, *plant, dataset);
    return dataset;
  };
  const Eigen::Index validation = std::clamp<Eigen::Index>(config.trajectories / 4, 8, 50);
  TrainingSets sets{set(SeedStream::kTraining, config.trajectories), set(SeedStream::kValidation, validation)};
  sets.warnings = std::move(warnings);
  if (needs_equations(experiment.loss)) add_equations(sets.training, *plant, experiment);
  if (structure_of(experiment.observer).flies_inputs()) {
    const InitialBox box = initial_box(config);
    sets.training.inputs = plant->inputs();
    sets.training.input_field = affine_input_field(*plant, box.low, box.high);
  }
  const PlantChannels channels(*experiment.plant, *plant);
  const bool reads_inputs = experiment.moves_inputs() && structure_of(experiment.observer).reads_inputs();
  for (Dataset* data : {&sets.training, &sets.validation}) {
    data->reads_inputs = reads_inputs;
    channels.apply(*data);
    data->mirror = mirror_of(mirrored_channels(experiment), data->readings(), data->states);
    check_swinging(*data);
  }
  return sets;
}

TrainingSets next_round(const Experiment& experiment, const LoopRound& round, TrainingSets before) {
  TrainingSets sets = simulate_training_sets(experiment, round);
  auto& runs = before.training.trajectories;
  std::move(sets.training.trajectories.begin(), sets.training.trajectories.end(), std::back_inserter(runs));
  sets.training.trajectories = std::move(runs);
  return sets;
}

}  // namespace nlo::trainer
