// SPDX-License-Identifier: MIT
// Trainings that leave groups of the training logs out, before the training on all of them. The readout that ships for
// a state (its network, a linear row, a blend) is chosen by the errors on the left-out groups, because a network that
// does not generalise fits its own logs as well as one that does.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "trainer/data/log_files.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

/// Groups of logs and the fold of each group, by deal_groups().
struct DealtLogs {
  std::vector<LogGroup> groups;
  std::vector<std::size_t> fold_of;  ///< one for each group
  std::size_t folds = 0;             ///< not more than groups
};

/// Groups the logs of `training` by [validation] groups, and deals them to `most_folds` at most. Throws codegen::Error
/// for a wrong pattern.
DealtLogs deal_logs(const Experiment& experiment, const Dataset& training, std::size_t most_folds);

/// Runs that are left out together, one Dataset for each group of logs among them.
struct FoldOfLogs {
  std::vector<std::string> names;  ///< names of the groups
  Dataset kept;
  std::vector<LeftOutLogs> left_out;
  bool is_part_of_log = false;  ///< a block of a single log
};

/// Returns the folds of [validation], dealt by deal_groups(). For a single log without validation_files the folds are
/// its blocks (log_blocks.h). Empty if there is nothing to choose: no log, `folds` 0, readout "network", a single log
/// with validation_files, or two groups. Throws codegen::Error for a wrong pattern.
std::vector<FoldOfLogs> folds_of_logs(const Experiment& experiment, const Dataset& training);

/// Called before each training: "without rubber_01.csv (1 of 4)", "on all logs".
using TrainingBegins = std::function<void(const std::string& what)>;

/// Trains on `logs` (or on a plant's runs) and on the simulated runs of a known plant (known_plant.h). Before that, one
/// training of half the steps for each fold runs in the folder DIRECTORY/without_1, ..._2 and so on. If the folds are
/// parts of a single log, it has at least 1,000 steps, or all if there are fewer. An interrupted fold is continued from
/// its folder. All these folders are removed at the end. An interruption in a fold gives a result without a model.
TrainingResult train_with_folds(const Experiment& experiment, const Dataset& logs, const Dataset& validation,
                                const TrainOptions& options, const TrainingBegins& begins = {});

/// Returns true if `directory` holds a training with folds that was interrupted.
bool folds_have_begun(const std::string& directory);

}  // namespace nlo::trainer
