// SPDX-License-Identifier: MIT
// The plots of a report, each made from the data of its section.
#pragma once

#include <vector>

#include "trainer/app/report/gnuplot.h"
#include "trainer/app/report/run_results.h"
#include "trainer/judge/evaluation/evaluation_study.h"

namespace nlo::trainer {

/// Draws loss and RMSE over the steps.
Figure training_figure(const TrainingCurves& curves);

/// Draws real and imaginary parts over the steps.
Figure eigenvalue_figure(const TrainingCurves& curves);

/// Draws the paths of the eigenvalues in the complex plane, from start (cross) to end (dot).
Figure eigenvalue_map(const TrainingCurves& curves);

/// Draws the error over time, averaged over the test set; one colour per noise, alternatives dashed. Has no panels if
/// the units of the states differ, because their errors cannot be added.
Figure error_figure(const std::vector<StudyRow>& rows);

/// Draws the times of a step and an estimate.
Figure latency_figure(const ControlLoopResult& result);

}  // namespace nlo::trainer
