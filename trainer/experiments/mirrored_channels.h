// SPDX-License-Identifier: MIT
// The channels that [training] mirror reverses.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Returns the names of the channels that change their sign in a mirror image: all except those that are declared even.
/// Empty unless [training] mirror is set.
std::vector<std::string> mirrored_channels(const Experiment& experiment);

}  // namespace nlo::trainer
