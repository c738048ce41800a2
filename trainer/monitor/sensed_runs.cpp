// SPDX-License-Identifier: MIT
#include "trainer/monitor/sensed_runs.h"

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

}  // namespace nlo::trainer
