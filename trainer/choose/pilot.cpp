// SPDX-License-Identifier: MIT
#include "trainer/choose/pilot.h"

#include <algorithm>
#include <limits>
#include <set>
#include <string>

#include "trainer/choose/left_out.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

Pilots::Pilots(const Experiment& experiment, const Dataset& training, const Dataset& validation, double settled_from_s)
    : training_(training), validation_(validation), settled_from_s_(settled_from_s) {
  if (!experiment.log || !experiment.log->validation_files.empty()) return;
  constexpr std::size_t kFolds = 4;
  const DealtLogs dealt = deal_logs(experiment, training, kFolds);
  if (dealt.groups.size() < 2) return;
  std::set<std::string> held_files;
  for (std::size_t g = 0; g < dealt.groups.size(); ++g)
    if (dealt.fold_of[g] == dealt.folds - 1)
      held_files.insert(dealt.groups[g].files.begin(), dealt.groups[g].files.end());
  kept_ = held_out_ = training;
  const auto held = [&](const Trajectory& run) { return held_files.contains(run.log); };
  std::erase_if(kept_.trajectories, held);
  std::erase_if(held_out_.trajectories, [&](const Trajectory& run) { return !held(run); });
}

double Pilots::error(const Experiment& experiment, int steps) const {
  constexpr int kValidations = 4;
  Experiment pilot = experiment;
  pilot.training.steps = std::min(steps, experiment.training.steps);
  pilot.training.validate_every = std::max(1, pilot.training.steps / kValidations);
  pilot.source_text = format_experiment(pilot);
  const Dataset& training = kept_.trajectories.empty() ? training_ : kept_;
  const Dataset& validation = held_out_.trajectories.empty() ? validation_ : held_out_;
  TrainOptions options;
  options.settled_from_s = settled_from_s_;
  const TrainingResult result = train(pilot, training, validation, options);
  return result.outcome == TrainOutcome::kDiverged ? std::numeric_limits<double>::infinity() : result.split.both();
}

}  // namespace nlo::trainer
