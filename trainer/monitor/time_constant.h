// SPDX-License-Identifier: MIT
// How long an observer and its plant remember: the time scale of a monitor.
#pragma once

#include "codegen/model/model.h"
#include "trainer/monitor/sensed_runs.h"

namespace nlo::trainer {

/// Of the slowest mode that reads an output, 1 / min |Re lambda|, where the latent system is linear; else 2 pi times
/// the outputs' correlation time (the integral of their autocorrelation up to its first zero), which is the period of
/// what oscillates. [s]
double time_constant_s(const codegen::Model& model, const SensedRuns& runs);

}  // namespace nlo::trainer
