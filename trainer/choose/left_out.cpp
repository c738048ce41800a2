// SPDX-License-Identifier: MIT
#include "trainer/choose/left_out.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <optional>
#include <set>
#include <utility>

#include "trainer/data/log_blocks.h"
#include "trainer/data/log_files.h"
#include "trainer/experiments/known_plant.h"
#include "trainer/experiments/load_experiment.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {
namespace {

constexpr std::size_t kFewestGroups = 3;  // with two groups, each training would see the logs of only one
constexpr int kShorter = 2;               // divisor of the steps; enough remain to recognise a network that generalises

/// Returns folds that leave out each block of a single log in turn.
std::vector<FoldOfLogs> folds_of_blocks(const LogGroup& log, const Dataset& training, int blocks) {
  std::vector<FoldOfLogs> folds;
  for (int b = 0; b < blocks; ++b) {
    std::optional<LeftOutBlock> parts = leave_out_block(training, b, blocks);
    if (!parts) continue;
    folds.push_back({.names = {fmt::format("part {} of {}", b + 1, log.name)},
                     .kept = std::move(parts->kept),
                     .left_out = {{log.kind, std::move(parts->left_out)}},
                     .is_part_of_log = true});
  }
  return folds;
}

/// Returns the simulated runs of the known plant that training adds to `logs`; empty without a known plant.
Dataset simulated_runs(const Experiment& experiment, const Dataset& logs) {
  Dataset simulated;
  if (!experiment.known) return simulated;
  simulated = logs;
  simulated.trajectories.clear();
  add_simulated_runs(experiment, simulated);
  return simulated;
}

/// Returns logs and simulated runs, the logs first. `own` holds the result if there are simulated runs.
const Dataset& joined(const Dataset& logs, const Dataset& simulated, Dataset& own) {
  if (simulated.trajectories.empty()) return logs;
  own = logs;
  own.trajectories.insert(own.trajectories.end(), simulated.trajectories.begin(), simulated.trajectories.end());
  own.simulated_share = simulated.simulated_share;
  return own;
}

/// Returns the steps of a training without some of the logs. A single log may need so few that half of them would be
/// too few.
int shorter_steps(int steps, bool of_single_log) {
  constexpr int kFewOfSingleLog = 1000;
  return std::max({1, steps / kShorter, of_single_log ? std::min(steps, kFewOfSingleLog) : 1});
}

std::string folder_of(const std::string& directory, std::size_t fold) {
  return directory.empty() ? "" : fmt::format("{}/without_{}", directory, fold + 1);
}

/// Removes checkpoints of another run, which a resumed one would take for its own.
void forget(const std::string& directory) {
  std::filesystem::remove(directory + "/checkpoint.bin");
  for (std::size_t f = 0; has_checkpoint(folder_of(directory, f)); ++f)
    std::filesystem::remove_all(folder_of(directory, f));
}

}  // namespace

DealtLogs deal_logs(const Experiment& experiment, const Dataset& training, std::size_t most_folds) {
  std::set<std::string> files;
  for (const Trajectory& run : training.trajectories) files.insert(run.log);
  DealtLogs dealt;
  dealt.groups = log_groups({files.begin(), files.end()}, experiment.validation.groups, "[validation] groups");
  dealt.folds = std::min(dealt.groups.size(), most_folds);
  dealt.fold_of = deal_groups(dealt.groups, dealt.folds);
  return dealt;
}

std::vector<FoldOfLogs> folds_of_logs(const Experiment& experiment, const Dataset& training) {
  const ValidationConfig& validation = experiment.validation;
  if (!experiment.log || validation.folds == 0 || !is_chosen(experiment.inverse_map.readout)) return {};
  const auto [groups, fold_of, count] =
      deal_logs(experiment, training, static_cast<std::size_t>(std::max(validation.folds, 2)));
  if (groups.size() == 1 && experiment.log->validation_files.empty())
    return folds_of_blocks(groups.front(), training, std::max(validation.folds, 2));
  if (groups.size() < kFewestGroups) return {};
  std::vector<FoldOfLogs> folds(count);
  for (FoldOfLogs& fold : folds) fold.kept = training;
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const LogGroup& group = groups[g];
    FoldOfLogs& fold = folds[fold_of[g]];
    const auto is_of_group = [&group](const Trajectory& run) {
      return std::ranges::find(group.files, run.log) != group.files.end();
    };
    fold.names.push_back(group.name);
    Dataset& own = fold.left_out.emplace_back(LeftOutLogs{group.kind, training}).logs;
    std::erase_if(own.trajectories, [&](const Trajectory& run) { return !is_of_group(run); });
    std::erase_if(fold.kept.trajectories, is_of_group);
  }
  std::erase_if(folds, [](const FoldOfLogs& fold) { return fold.left_out.empty(); });
  return folds;
}

TrainingResult train_with_folds(const Experiment& experiment, const Dataset& logs, const Dataset& validation,
                                const TrainOptions& options, const TrainingBegins& begins) {
  const std::vector<FoldOfLogs> folds = folds_of_logs(experiment, logs);
  const Dataset simulated = simulated_runs(experiment, logs);
  Dataset both;
  const Dataset& training = joined(logs, simulated, both);
  if (folds.empty()) return train(experiment, training, validation, options);
  Experiment shorter = experiment;
  shorter.training.steps = shorter_steps(experiment.training.steps, folds.front().is_part_of_log);
  shorter.source_text = format_experiment(shorter);
  if (!options.resume && !options.directory.empty()) forget(options.directory);
  TrainOptions all = options;
  for (std::size_t f = 0; f < folds.size(); ++f) {
    const FoldOfLogs& fold = folds[f];
    if (begins) begins(fmt::format("without {} ({} of {})", fmt::join(fold.names, ", "), f + 1, folds.size()));
    TrainOptions own = options;
    own.directory = folder_of(options.directory, f);
    own.resume = options.resume && has_checkpoint(own.directory);
    own.left_out = fold.left_out;
    // Without validation logs, the kept training logs also select the parameters.
    const bool has_validation = !experiment.log->validation_files.empty();
    Dataset kept;
    TrainingResult result =
        train(shorter, joined(fold.kept, simulated, kept), has_validation ? validation : fold.kept, own);
    if (result.outcome == TrainOutcome::kInterrupted) {
      result.model = {};
      result.message = fmt::format("training {} of {} without some of the logs", f + 1, folds.size());
      return result;
    }
    std::ranges::move(result.left_out, std::back_inserter(all.evidence));
  }
  if (begins) begins("on all logs");
  all.resume = options.resume && has_checkpoint(options.directory);
  TrainingResult result = train(experiment, training, validation, all);
  if (result.outcome != TrainOutcome::kInterrupted && !options.directory.empty())
    for (std::size_t f = 0; f < folds.size(); ++f) std::filesystem::remove_all(folder_of(options.directory, f));
  return result;
}

bool folds_have_begun(const std::string& directory) {
  return has_checkpoint(folder_of(directory, 0));
}

}  // namespace nlo::trainer
