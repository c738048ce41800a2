// SPDX-License-Identifier: MIT
#include "trainer/plants/simulate_runs.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string_view>
#include <vector>

#include "codegen/reference/rk4.h"
#include "trainer/plants/drawn_inputs.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/run_random.h"
#include "trainer/plants/simulate.h"

namespace nlo::trainer {
namespace {

/// u (n_u x B, or 0 x B) of the runs of a batch in the step from sample k on, when the part c of it is over.
using StepInputs = std::function<Eigen::MatrixXd(Eigen::Index k, double c)>;

/// Some runs of a set, side by side: they have the same plant.
struct Batch {
  Eigen::Index first, count;
};

StepInputs step_inputs(const Experiment& experiment, const Excitation& given, const Dataset& set, const Batch& batch) {
  if (given)
    return [&given, count = batch.count, h = set.sample_period_s](Eigen::Index k, double c) -> Eigen::MatrixXd {
      return given(static_cast<double>(k) * h + c * h).replicate(1, count);
    };
  const auto nu = static_cast<Eigen::Index>(set.inputs.size());
  const auto at_sample = [&set, batch, nu](Eigen::Index k) {
    Eigen::MatrixXd u(nu, batch.count);
    for (Eigen::Index i = 0; i < batch.count && nu > 0; ++i)
      u.col(i) = set.trajectories[static_cast<std::size_t>(batch.first + i)].inputs.col(k);
    return u;
  };
  if (experiment.observer.input_hold == Hold::kZeroOrder)
    return [at_sample](Eigen::Index k, double) { return at_sample(k + 1); };
  return [at_sample](Eigen::Index k, double c) -> Eigen::MatrixXd {
    return (1.0 - c) * at_sample(k) + c * at_sample(k + 1);
  };
}

void simulate_batch(const Plant& plant, const Experiment& experiment, const Eigen::MatrixXd& initial,
                    std::uint64_t engine_seed, const Batch& batch, const StepInputs& inputs, Dataset& set) {
  const double h = set.sample_period_s;
  const Eigen::Index samples = sample_count(experiment.simulation);
  const auto& intensity = experiment.simulation.process_noise;
  const Eigen::ArrayXd deviation =
      std::sqrt(h) * Eigen::ArrayXd::Map(intensity.data(), static_cast<Eigen::Index>(intensity.size()));
  std::vector<RunRandom> disturbances;
  for (Eigen::Index i = 0; i < batch.count; ++i)
    disturbances.emplace_back(engine_seed, RunPurpose::kProcessNoise, 0, static_cast<std::uint64_t>(batch.first + i));

  Eigen::MatrixXd x = initial.middleCols(batch.first, batch.count);
  const Eigen::MatrixXd start = x;
  for (Eigen::Index k = 0; k < samples; ++k) {
    const Eigen::MatrixXd y = plant.output(x);
    refuse_escape(plant, x, start, static_cast<double>(k) * h);
    refuse_escape(plant, y, start, static_cast<double>(k) * h);
    for (Eigen::Index i = 0; i < batch.count; ++i) {
      Trajectory& run = set.trajectories[static_cast<std::size_t>(batch.first + i)];
      run.states.col(k) = x.col(i);
      run.outputs.col(k) = y.col(i);
    }
    if (k + 1 == samples) return;
    x = codegen::rk4_step(
        x, h, [&](double c, const Eigen::MatrixXd& at) { return plant.driven_derivative(at, inputs(k, c)); });
    for (Eigen::Index i = 0; i < batch.count; ++i)
      for (Eigen::Index row = 0; row < deviation.size(); ++row)
        x(row, i) += deviation(row) * disturbances[static_cast<std::size_t>(i)].normal();
  }
}

/// Inputs at the samples: drawn, or of u(t).
void fill_inputs(const Experiment& experiment, const Plant& plant, std::uint64_t engine_seed, const Excitation& given,
                 Dataset& set) {
  if (!given && !experiment.excitation) return;
  set.inputs = plant.inputs();
  const LoggedInputs log = given ? LoggedInputs{} : read_logged_inputs(*experiment.excitation, experiment.simulation);
  for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
    Trajectory& run = set.trajectories[i];
    if (!given) {
      run.inputs = draw_inputs(*experiment.excitation, experiment.simulation, engine_seed, i, log);
      continue;
    }
    run.inputs.resize(plant.nu(), run.samples());
    for (Eigen::Index k = 0; k < run.samples(); ++k)
      run.inputs.col(k) = given(static_cast<double>(k) * set.sample_period_s);
  }
}

/// By its name, a parameter keeps its stream whatever else is drawn (FNV-1a).
std::uint64_t stream_of(std::string_view name) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return hash;
}

}  // namespace

PlantConfig draw_parameters(const PlantConfig& plant, std::uint64_t engine_seed, std::uint64_t run) {
  PlantConfig drawn = plant;
  drawn.parameter_ranges.clear();
  for (const auto& [name, range] : plant.parameter_ranges) {
    RunRandom random(engine_seed, RunPurpose::kParameters, stream_of(name), run);
    for (auto& [parameter, value] : drawn.parameters)
      if (parameter == name) value = random.between(range[0], range[1]);
  }
  return drawn;
}

Dataset simulate_runs(const Experiment& experiment, const Plant& plant, std::uint64_t engine_seed, Eigen::Index count,
                      double box_scale, const Excitation& given) {
  const SimulationConfig& simulation = experiment.simulation;
  const bool own_plants = !experiment.plant->parameter_ranges.empty();
  const bool drawn_inputs = experiment.excitation && !given;
  if (!own_plants && !drawn_inputs && simulation.process_noise.empty())
    return simulate(plant, simulation, engine_seed, count, box_scale, given);

  const Eigen::MatrixXd initial = draw_initial_states(simulation, engine_seed, count, box_scale);
  Dataset set = empty_runs(plant, simulation, count);
  fill_inputs(experiment, plant, engine_seed, given, set);
  if (!own_plants) {
    const Batch all{0, count};
    simulate_batch(plant, experiment, initial, engine_seed, all, step_inputs(experiment, given, set, all), set);
  } else {
    for (Eigen::Index i = 0; i < count; ++i) {
      const Batch one{i, 1};
      const auto own = make_plant(draw_parameters(*experiment.plant, engine_seed, static_cast<std::uint64_t>(i)));
      simulate_batch(*own, experiment, initial, engine_seed, one, step_inputs(experiment, given, set, one), set);
    }
  }
  unwrap_outputs(set);
  return set;
}

}  // namespace nlo::trainer
