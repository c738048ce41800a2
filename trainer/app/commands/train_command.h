// SPDX-License-Identifier: MIT
// nlo train as a function, for commands that run it.
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

/// Throws codegen::Error for wrong input, RunFailure when the training was interrupted or failed.
void run_train(const TrainArguments& arguments);

/// Reads the experiment to be trained. Throws codegen::Error.
DraftExperiment draft_to_train(const TrainArguments& arguments);

/// Carries out the training of `draft` in a folder that the caller has taken: get the data, train, judge, write.
/// Reads data, resume and quiet of `arguments`; the others only appear in the hint how to resume.
/// Throws as run_train().
void carry_out(const DraftExperiment& draft, const TrainArguments& arguments, const RunFolder& folder);

}  // namespace nlo::trainer
