// SPDX-License-Identifier: MIT
// nlo train --auto: searches for an experiment that is better than the given one, then trains it.
#pragma once

#include "trainer/app/commands/auto_search.h"
#include "trainer/app/commands/train_command.h"

namespace nlo::trainer {

/// Writes the files of nlo train, experiment.toml with the result of the search, auto.html with all trials, and
/// auto.json with the trials for programs. Throws like run_train() and run_search().
void run_train_auto(const TrainArguments& arguments, const SearchBudget& budget);

}  // namespace nlo::trainer
