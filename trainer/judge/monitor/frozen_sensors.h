// SPDX-License-Identifier: MIT
// Conditions under which a monitor (nlo/monitor.h) considers a sensor frozen.
#pragma once

#include "codegen/model/model.h"
#include "trainer/judge/monitor/sensed_runs.h"

namespace nlo::trainer {

/// Sets the values that distinguish a frozen sensor from one at rest, for each measured output:
///   most_moved  twice the largest change that was predicted in training during equal readings
///   most_equal  number of equal readings in a row. It is set if the logs have hardly any equal readings, which shows a
///   sensor of high resolution. For outputs that may fail it exceeds nearly all numbers in the logs, except at rest
///   (resting, reference_sensor, rest_min, rest_max). It is not set for simulated runs, because they do not show the
///   resolution of the sensor
/// The predictions of the monitor must be fitted already. Without runs no sensor is frozen.
void fit_frozen(codegen::Monitor& monitor, const SensedRuns& runs, bool simulated, const codegen::Model& model);

}  // namespace nlo::trainer
