// SPDX-License-Identifier: MIT
#include "trainer/commands/search_judge.h"

#include "trainer/evaluation/evaluate.h"
#include "trainer/evaluation/metrics_config.h"
#include "trainer/plants/initial_states.h"
#include "trainer/plants/plant_channels.h"
#include "trainer/plants/registry.h"
#include "trainer/plants/simulate_runs.h"

namespace nlo::trainer {

SearchJudge::SearchJudge(const Experiment& experiment, const Dataset& validation) : experiment_(experiment) {
  if (experiment.plant) {
    constexpr int kRuns = 100;
    constexpr std::uint64_t kNoTest = 0x6175746fULL;  // far from the seeds that people give tests
    const auto plant = make_plant(*experiment.plant);
    runs_ = simulate_runs(experiment, *plant, initial_state_seed(experiment.seed ^ kNoTest, SeedStream::kTest), kRuns);
    PlantChannels(*experiment.plant, *plant).apply(runs_);
    config_ = metrics_config(experiment, experiment.simulation.horizon_s);
  } else {
    runs_ = validation;
    config_ = metrics_config(experiment, runs_);
  }
  if (experiment.loss.is_normalised() || !share_a_unit(runs_.states)) config_.state_scale = state_deviation(runs_);
}

double SearchJudge::error(const codegen::Model& model) const {
  const NoiseMixture noise = experiment_.training.all_noise();
  double sum = 0.0;
  for (const NoiseConfig& part : noise.parts)
    sum += evaluate_on_plant(model, runs_, part, experiment_.seed, experiment_.threads, config_).metrics.norm;
  return sum / static_cast<double>(noise.parts.size());
}

}  // namespace nlo::trainer
