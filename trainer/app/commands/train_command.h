// SPDX-License-Identifier: MIT
// nlo train as a function, for commands that run it.
#pragma once

#include <string>

#include "trainer/app/commands/experiment_argument.h"

namespace nlo::trainer {

struct TrainArguments {
  ExperimentArgument experiment;
  std::string data, output;
  bool resume = false, force = false, quiet = false, help_config = false;
};

/// Throws codegen::Error for wrong input, RunFailure when the training was interrupted or failed.
void run_train(TrainArguments arguments);

}  // namespace nlo::trainer
