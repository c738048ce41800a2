// SPDX-License-Identifier: MIT
// Error against cost: the points of a sweep, and those that no other point beats in both.
#pragma once

#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/app/sweep/results.h"

namespace nlo::trainer {

/// Draws panels: error against multiply-adds, against bytes of flash, and against ns if it was measured. They have bars
/// of one standard error, and the front as a staircase with the titles of its points. There are no panels if no point
/// has an error and a cost.
Figure pareto_figure(const std::vector<PointResult>& points);

}  // namespace nlo::trainer
