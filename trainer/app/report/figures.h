// SPDX-License-Identifier: MIT
// Which plots a report has: each from the data of its section.
#pragma once

#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/app/report/run_results.h"
#include "trainer/judge/evaluation/evaluation_study.h"

namespace nlo::trainer {

/// Loss and RMSE over the steps.
Figure training_figure(const TrainingCurves& curves);

/// Real and imaginary parts over the steps.
Figure eigenvalue_figure(const TrainingCurves& curves);

/// Their paths in the complex plane, from start (cross) to end (dot).
Figure eigenvalue_map(const TrainingCurves& curves);

/// Error over time, averaged over the test set; one colour per noise, alternatives dashed. Without panels when the
/// states' units differ: their errors do not add up.
Figure error_figure(const std::vector<StudyRow>& rows);

/// Time that one step and estimate took.
Figure latency_figure(const ControlLoopResult& result);

}  // namespace nlo::trainer
