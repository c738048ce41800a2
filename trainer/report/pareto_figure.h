// SPDX-License-Identifier: MIT
// Error against cost: the points of a sweep, and those that no other one beats in both.
#pragma once

#include <vector>

#include "trainer/report/gnuplot.h"
#include "trainer/sweep/results.h"

namespace nlo::trainer {

/// Two panels: error against multiply-adds and against bytes of flash, bars of one standard error, the front as a
/// staircase. Without panels when no point has an error and a cost.
Figure pareto_figure(const std::vector<PointResult>& points);

}  // namespace nlo::trainer
