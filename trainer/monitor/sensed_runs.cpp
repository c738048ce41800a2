// SPDX-License-Identifier: MIT
#include "trainer/monitor/sensed_runs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "codegen/structures/module.h"
#include "trainer/data/measurement_noise.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {

SensedRuns sensed_runs(const Experiment& experiment, const std::vector<NoiseConfig>& noises, double horizon_s,
                       std::uint64_t seed, int count) {
  Experiment longer = experiment;
  longer.simulation.horizon_s = horizon_s;
  const auto plant = make_plant(*longer.plant);
  const std::uint64_t engine = initial_state_seed(seed, SeedStream::kValidation);
  Dataset set = simulate_runs(longer, *plant, engine, count);
  PlantChannels(*longer.plant, *plant).apply(set);
  SensedRuns runs;
  for (std::size_t i = 0; i < set.trajectories.size(); ++i) {
    const MeasurementNoise noise(noises[i % noises.size()], engine, i);
    runs.outputs.push_back(MeasurementNoise(noise).on(set.trajectories[i].outputs, set.output_angles));
    runs.inputs.push_back(set.trajectories[i].inputs);
  }
  return runs;
}

SensedRuns sensed_runs(const Dataset& logs) {
  SensedRuns runs;
  for (const Trajectory& run : logs.trajectories) {
    runs.outputs.push_back(run.outputs);
    runs.inputs.push_back(run.inputs);
    if (!logs.uniform) runs.time_s.push_back(run.time_s);
  }
  return runs;
}

namespace {

using Eigen::Index;

/// Of one output over all runs, in samples. Samples that did not arrive count as the mean.
double correlation_samples(const SensedRuns& runs, Index output) {
  double sum = 0.0, count = 0.0;
  for (const Eigen::MatrixXd& y : runs.outputs)
    for (Index k = 0; k < y.cols(); ++k)
      if (std::isfinite(y(output, k))) sum += y(output, k), count += 1.0;
  const double mean = count > 0.0 ? sum / count : 0.0;
  const auto value = [&](const Eigen::MatrixXd& y, Index k) {
    return std::isfinite(y(output, k)) ? y(output, k) - mean : 0.0;
  };
  const auto product = [&](Index lag) {
    double total = 0.0;
    for (const Eigen::MatrixXd& y : runs.outputs)
      for (Index k = lag; k < y.cols(); ++k) total += value(y, k) * value(y, k - lag);
    return total;
  };
  const double first = product(1);  // not at lag 0, where the noise is
  double integral = 0.5;
  for (Index lag = 1; first > 0.0; ++lag) {
    const double share = product(lag) / first;
    if (!(share > 0.0)) break;
    integral += share;
  }
  return integral;
}

}  // namespace

double time_constant_s(const codegen::Model& model, const SensedRuns& runs) {
  if (const auto slowest = codegen::module_of(model).slowest_mode(model)) return 1.0 / *slowest;
  double longest = 0.0;
  for (Index j = 0; j < model.ny(); ++j) longest = std::max(longest, correlation_samples(runs, j));
  return 2.0 * std::numbers::pi * longest * model.sample_period_s;
}

}  // namespace nlo::trainer
