// SPDX-License-Identifier: MIT
#pragma once

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Whether an experiment has the forward map T: its structure flies it, or a loss is about it.
bool uses_forward_map(const Experiment& experiment);

}  // namespace nlo::trainer
