// SPDX-License-Identifier: MIT
// Ctrl-C while something long runs.
#pragma once

#include <atomic>

namespace nlo::trainer {

/// From now on the first SIGINT or SIGTERM sets the flag returned, and the run is to save and stop; a second one kills,
/// as everywhere.
const std::atomic<bool>& stop_on_interrupt();

}  // namespace nlo::trainer
