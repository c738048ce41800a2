// SPDX-License-Identifier: MIT
// Finds states of simulated runs that go far out of the box of their initial states, or that grow without bound.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Returns a warning for each state that
///   leaves  goes farther than ten half widths of the box of initial states from its centre. A state that starts at one
///           point is not tested for this, because its box has no width
///   grows   has its largest distance over all runs in the last quarter of the horizon, beyond three half widths, and
///           there it is 1.8 times the largest one of the first half (5 times if the state starts at one point)
/// A warning has the range, the time and the remedy. Angles that wrap are left out. Empty if there is none.
///   runs        runs of the plant's own states (before PlantChannels), from t = 0
///   experiment  the experiment of these runs: box, horizon, and whether a loop is closed
std::vector<std::string> range_warnings(const Dataset& runs, const Experiment& experiment);

/// Returns the first state that an output measures itself and nothing else of the plant depends on, like the count of
/// an encoder; empty if there is none. Such a state may count without end. Angles with a full turn are left out.
std::string counted_state(const PlantConfig& plant);

}  // namespace nlo::trainer
