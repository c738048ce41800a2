// SPDX-License-Identifier: MIT
#include "trainer/choose/pilot.h"

#include <algorithm>
#include <limits>
#include <map>

#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

PilotData::PilotData(const Experiment& experiment, const Dataset& training, const Dataset& validation)
    : training_(training), validation_(validation) {
  if (!experiment.log || !experiment.log->validation_files.empty()) return;
  constexpr std::size_t kPart = 4;
  std::map<std::string, std::size_t> logs;
  for (const Trajectory& run : training.trajectories) logs.emplace(run.log, logs.size());
  if (logs.size() < 2) return;
  const std::size_t part = std::min(kPart, logs.size());
  kept_ = held_out_ = training;
  const auto held = [&](const Trajectory& run) { return logs.at(run.log) % part == part - 1; };
  std::erase_if(kept_.trajectories, held);
  std::erase_if(held_out_.trajectories, [&](const Trajectory& run) { return !held(run); });
}

double pilot_error(const Experiment& experiment, int steps, const PilotData& data) {
  constexpr int kValidations = 4;
  Experiment pilot = experiment;
  pilot.training.steps = std::min(steps, experiment.training.steps);
  pilot.training.validate_every = std::max(1, pilot.training.steps / kValidations);
  pilot.source_text = format_experiment(pilot);
  const TrainingResult result = train(pilot, data.training(), data.validation(), {});
  return result.outcome == TrainOutcome::kDiverged ? std::numeric_limits<double>::infinity() : result.validation_rmse;
}

}  // namespace nlo::trainer
