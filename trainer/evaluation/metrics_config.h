// SPDX-License-Identifier: MIT
// How an experiment has its runs judged.
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/evaluation/metrics.h"

namespace nlo::trainer {

/// Windows and settling as the experiment says, else by its observer and this horizon.
MetricsConfig metrics_config(const Experiment& experiment, double horizon_s);

/// The same with the longest of these logs as the horizon.
MetricsConfig metrics_config(const Experiment& experiment, const Dataset& logs);

}  // namespace nlo::trainer
