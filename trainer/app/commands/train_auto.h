// SPDX-License-Identifier: MIT
// nlo train --auto: a search for an experiment that is better than the one given, then its training.
#pragma once

#include "trainer/app/commands/auto_search.h"
#include "trainer/app/commands/train_command.h"

namespace nlo::trainer {

/// Writes what nlo train does, and experiment.toml, what was found, auto.html, what was tried, and auto.json, the same
/// for programs. Throws as run_train and run_search do.
void run_train_auto(const TrainArguments& arguments, const SearchBudget& budget);

}  // namespace nlo::trainer
