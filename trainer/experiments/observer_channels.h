// SPDX-License-Identifier: MIT
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

/// Counts the channels of an experiment's observer. The plant or the columns must be valid.
ChannelCounts observer_channels(const Experiment& experiment);

/// Returns true if an experiment has the forward map T, because its structure uses T in flight or a loss contains T.
bool uses_forward_map(const Experiment& experiment);

}  // namespace nlo::trainer
