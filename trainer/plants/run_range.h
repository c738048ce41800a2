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

}  // namespace nlo::trainer
