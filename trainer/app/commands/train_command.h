// SPDX-License-Identifier: MIT
// nlo train as a function, for other commands.
#pragma once

#include <string>

#include "trainer/app/commands/experiment_argument.h"
#include "trainer/app/commands/run_folder.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {

struct TrainArguments {
  ExperimentArgument experiment;
  std::string data, output;
  bool resume = false, force = false, quiet = false;
};

/// Trains. Throws codegen::Error for wrong input, and RunFailure if the training was interrupted or failed.
void run_train(const TrainArguments& arguments);

/// Reads the experiment to be trained. Throws codegen::Error.
DraftExperiment draft_to_train(const TrainArguments& arguments);

/// Carries out the training of `draft` in a folder that the caller has locked: gets the data, trains, tests and writes.
/// Uses data, resume and quiet of `arguments`; the others only appear in the hint on resuming. Throws like run_train().
void carry_out(const DraftExperiment& draft, const TrainArguments& arguments, const RunFolder& folder);

}  // namespace nlo::trainer
