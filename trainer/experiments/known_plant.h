// SPDX-License-Identifier: MIT
// Experiments with both [plant] and [log]. Training uses simulated runs of the plant beside the logs: the runs begin in
// states where no log begins, and the logs contain effects that the equations omit.
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Throws KeyError unless the plant has each measured output, state and input of the logs, with the same name, unit and
/// wrap.
void check_known_plant(const Experiment& experiment);

/// Adds runs of the plant to those of the logs. They have the sample period of the logs and get the noise of the
/// sensors ([simulation] noise), which logs already contain. Does nothing without a known plant or with share = 0.
/// Throws codegen::Error if a run overflows.
void add_simulated_runs(const Experiment& experiment, Dataset& logs);

}  // namespace nlo::trainer
