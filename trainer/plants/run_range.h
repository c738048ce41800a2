// SPDX-License-Identifier: MIT
// Simulated runs that go where nobody asked for: far out of the box that they start in, or farther and farther.
#pragma once

#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// A line for each state that
///   leaves  goes farther than ten half widths of the box of initial states from its centre; a state that starts at one
///           point has no width, and is not asked
///   grows   is at its farthest, over all runs, in the last quarter of the horizon: 1.8 times its largest value in the
/// first half (5 times where it starts at one point), and beyond three half widths with the range, the time and the
/// remedy. States that wrap are left out: an angle may turn. Empty: there are none.
///   runs        of the plant's own states (before PlantChannels), from t = 0
///   experiment  they are of: box, horizon, and whether a loop is closed
std::vector<std::string> range_warnings(const Dataset& runs, const Experiment& experiment);

/// Returns the first state that an output measures itself and nothing else of the plant depends on, like the count of
/// an encoder; empty if there is none. It may count without end. Angles with a full turn are left out.
std::string counted_state(const PlantConfig& plant);

}  // namespace nlo::trainer
