// SPDX-License-Identifier: MIT
#include "trainer/prove/steady_states.h"

#include <algorithm>

#include "codegen/replay/reference_observer.h"
#include "trainer/judge/evaluation/disturbed_runs.h"
#include "trainer/plants/initial_states.h"
#include "trainer/prove/latent_memory.h"

namespace nlo::trainer {

using Eigen::MatrixXd;

SteadyStates steady_states(const codegen::Model& model, const Plant& plant, SimulationConfig simulation,
                           double disturbance, int trajectories, std::uint64_t seed) {
  const double settled_s = static_cast<double>(LatentMemory(model).steps) * model.sample_period_s;
  simulation.horizon_s = std::max(simulation.horizon_s, 2.0 * settled_s);
  const MatrixXd initial = draw_initial_states(simulation, initial_state_seed(seed, SeedStream::kTest), trajectories);
  const Dataset quiet = simulate_disturbed(plant, simulation, initial, 0.0, seed).set;
  const Eigen::Index samples = quiet.trajectories.front().samples(), first = samples / 2, kept = samples - first;
  const Eigen::Index all = kept * trajectories;
  SteadyStates states{MatrixXd(plant.nx(), all), MatrixXd(plant.nx(), all), MatrixXd(model.nz(), all)};
  codegen::ReferenceObserver<double> observer(model);
  for (Eigen::Index i = 0; i < trajectories; ++i) {
    const Trajectory& run = quiet.trajectories[static_cast<std::size_t>(i)];
    states.x.middleCols(i * kept, kept) = run.states.rightCols(kept);
    observer.reset();
    for (Eigen::Index k = 0; k < samples; ++k) {
      observer.step(run.outputs.col(k));
      if (k >= first) states.z.col(i * kept + k - first) = observer.latent();
    }
  }
  states.visited = states.x;
  if (disturbance == 0.0) return states;
  const Dataset pushed = simulate_disturbed(plant, simulation, initial, disturbance, seed).set;
  states.visited.conservativeResize(Eigen::NoChange, 2 * all);
  for (Eigen::Index i = 0; i < trajectories; ++i)
    states.visited.middleCols(all + i * kept, kept) =
        pushed.trajectories[static_cast<std::size_t>(i)].states.rightCols(kept);
  return states;
}

}  // namespace nlo::trainer
