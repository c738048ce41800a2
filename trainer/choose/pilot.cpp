// SPDX-License-Identifier: MIT
#include "trainer/choose/pilot.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "trainer/choose/left_out.h"
#include "trainer/data/log_blocks.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {
namespace {

/// Returns the geometric mean, over states and windows, of the error that can ship: the smaller one of T* and the
/// linear rows, as a share of the state's deviation there. A state that is constant there does not count.
double error_of_best_readouts(const JudgedSet& judged, bool rows_may_ship) {
  constexpr double kLeast = 1e-6;  // smaller squares are rounding
  double logs = 0.0, counted = 0.0;
  for (const SetSquares& window : judged.windows)
    for (const StateSquares& state : window) {
      if (state.deviation <= 0.0) continue;
      double least = state.map;
      if (rows_may_ship)
        for (const double row : state.row) least = std::min(least, row);
      logs += std::log(std::max(least / state.deviation, kLeast)) / 2.0;
      counted += 1.0;
    }
  return counted > 0.0 ? std::exp(logs / counted) : 1.0;
}

}  // namespace

Pilots::Pilots(const Experiment& experiment, const Dataset& training, const Dataset& validation, double settled_from_s)
    : training_(training), validation_(validation), settled_from_s_(settled_from_s) {
  if (!experiment.log || !experiment.log->validation_files.empty()) return;
  constexpr std::size_t kFolds = 4;
  const DealtLogs dealt = deal_logs(experiment, training, kFolds);
  if (dealt.groups.size() == 1) hold_out_last_quarter();
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

void Pilots::hold_out_last_quarter() {
  constexpr int kBlocks = 4;
  std::optional<LeftOutBlock> parts = leave_out_block(training_, kBlocks - 1, kBlocks);
  if (!parts) return;
  kept_ = std::move(parts->kept);
  held_out_ = std::move(parts->left_out);
  holds_out_a_part_ = true;
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
  if (holds_out_a_part_) options.left_out = {{"", held_out_}};
  const TrainingResult result = train(pilot, training, validation, options);
  if (result.outcome == TrainOutcome::kDiverged) return std::numeric_limits<double>::infinity();
  if (result.left_out.empty()) return result.split.both();
  return error_of_best_readouts(result.left_out.front().squares, is_chosen(experiment.inverse_map.readout));
}

int Pilots::best_steps(const Experiment& experiment) const {
  const int most = experiment.training.steps;
  int best = most;
  double least = std::numeric_limits<double>::infinity();
  for (const int share : {1, 4, 16}) {
    const int steps = std::max(1, most / share);
    if (const double tried = error(experiment, steps); tried < least) {
      least = tried;
      best = steps;
    }
  }
  return best;
}

}  // namespace nlo::trainer
