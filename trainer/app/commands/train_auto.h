// SPDX-License-Identifier: MIT
// nlo train --auto: a search for an experiment that is better than the one given, then its training.
#pragma once

#include "trainer/app/commands/auto_search.h"
#include "trainer/app/commands/train_command.h"

namespace nlo::trainer {

/// Writes the files of nlo train, experiment.toml with the result of the search, auto.html with all trials, and
/// auto.json, the trials for programs. Throws as run_train and run_search do.
void run_train_auto(const TrainArguments& arguments, const SearchBudget& budget);

}  // namespace nlo::trainer
