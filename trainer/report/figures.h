// SPDX-License-Identifier: MIT
// Which plots a report has: each from the data of its section.
#pragma once

#include <vector>

#include "trainer/analysis/evaluate.h"
#include "trainer/report/control_loop_result.h"
#include "trainer/report/gnuplot.h"
#include "trainer/report/training_curves.h"

namespace nlo::trainer {

/// Loss and RMSE over the steps.
Figure training_figure(const TrainingCurves& curves);

/// Real and imaginary parts over the steps.
Figure eigenvalue_figure(const TrainingCurves& curves);

/// Their paths in the complex plane, from start (cross) to end (dot).
Figure eigenvalue_map(const TrainingCurves& curves);

/// Truth, estimate and measurement over the first `seconds`; a panel per state, and one for the outputs unless each is
/// a state itself.
Figure run_figure(const EvaluatedRun& run, const std::vector<Channel>& states, const std::vector<Channel>& outputs,
                  double seconds);

/// Error over time, averaged over the test set; one colour per noise, alternatives dashed.
Figure error_figure(const std::vector<std::vector<Evaluation>>& groups);

/// Time that one step and estimate took.
Figure latency_figure(const ControlLoopResult& result);

}  // namespace nlo::trainer
