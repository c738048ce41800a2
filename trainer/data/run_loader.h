// SPDX-License-Identifier: MIT
// Reads a run of a log for training: columns as channels, angles unwrapped, velocities by the zero-phase filter, time
// from the first sample, and a weight of 0 if the truth does not count.
#pragma once

#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/data/log_checks.h"
#include "trainer/data/log_file.h"
#include "trainer/data/log_schema.h"

namespace nlo::trainer {

/// Loads one run, see load_logs(). `steps` gets the steps of the columns that are read. Throws codegen::Error if no
/// truth of the run counts.
Trajectory load_run(const LogConfig& config, const LogSchema& schema, double sample_period_s, const LogFile& log,
                    const LogRun& run, std::vector<SuspiciousSteps>& steps);

}  // namespace nlo::trainer
