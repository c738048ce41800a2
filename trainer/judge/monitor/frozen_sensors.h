// SPDX-License-Identifier: MIT
// When a monitor (nlo/monitor.h) takes a sensor for frozen.
#pragma once

#include "codegen/model/model.h"
#include "trainer/judge/monitor/sensed_runs.h"

namespace nlo::trainer {

/// Sets the values that distinguish a frozen sensor from one at rest, for each measured output:
///   most_moved  twice the largest change that was predicted, in training, while the reading stayed the same
///   most_equal  a count of equal readings, where logs have hardly any: a sensor of high resolution. For outputs that
///               may fail, more than nearly all of the logs', less those at rest (resting, reference_sensor, rest_min,
///               rest_max).
///               None for simulated runs: they do not show the resolution of the sensor.
/// Its predictions must be fitted already. Without runs no sensor is frozen.
void fit_frozen(codegen::Monitor& monitor, const SensedRuns& runs, bool simulated, const codegen::Model& model);

}  // namespace nlo::trainer
