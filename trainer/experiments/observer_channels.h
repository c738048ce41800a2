// SPDX-License-Identifier: MIT
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

/// The channels of an experiment's observer, whose plant or columns are valid.
ChannelCounts observer_channels(const Experiment& experiment);

/// Whether an experiment has the forward map T: its structure flies it, or a loss is about it.
bool uses_forward_map(const Experiment& experiment);

}  // namespace nlo::trainer
