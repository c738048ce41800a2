// SPDX-License-Identifier: MIT
// Equations and logs together: an experiment with [plant] and [log]. Simulated runs of the plant are trained on beside
// the logs: they begin in states where no log does, and the logs contain effects that the equations omit.
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Throws KeyError unless the plant has each measured output, state and input of the logs, by name, unit and wrap.
void check_known_plant(const Experiment& experiment);

/// Adds the plant's runs, at the logs' sample period, to those of the logs, with the sensors' noise ([simulation]
/// noise), which logs have already. Nothing without a known plant or with share = 0. Throws codegen::Error where a run
/// overflows.
void add_simulated_runs(const Experiment& experiment, Dataset& logs);

}  // namespace nlo::trainer
