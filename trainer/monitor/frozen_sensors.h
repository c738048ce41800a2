// SPDX-License-Identifier: MIT
// When the gate of a monitor (nlo/monitor.h) takes a sensor for frozen.
#pragma once

#include "codegen/model/model.h"
#include "trainer/monitor/sensed_runs.h"

namespace nlo::trainer {

/// most_equal, resting, witness, rest_min and rest_max, for the outputs that may be missing: of others a repeated
/// reading is all that an observer can hold. Without runs no sensor is frozen.
void fit_frozen(codegen::Monitor& monitor, const SensedRuns& runs, const codegen::Model& model);

}  // namespace nlo::trainer
