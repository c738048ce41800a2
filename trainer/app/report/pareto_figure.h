// SPDX-License-Identifier: MIT
// Error against cost: the points of a sweep, and those that no other one beats in both.
#pragma once

#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/app/sweep/results.h"

namespace nlo::trainer {

/// Panels: error against multiply-adds, against bytes of flash and, where it was measured, against ns; bars of one
/// standard error, the front as a staircase with the titles of its points.
/// Without panels when no point has an error and a cost.
Figure pareto_figure(const std::vector<PointResult>& points);

}  // namespace nlo::trainer
