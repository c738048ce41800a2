// SPDX-License-Identifier: MIT
// The start of the training of an observer with a prior: ranges, scales, and noises from the residuals of the
// equations.
#pragma once

#include "trainer/rollout/training_data.h"
#include "trainer/structures/prior_lanes.h"

namespace nlo::trainer {

/// Fills the parts of the setting that come from data: start, range, fine and coarse, noises, scales and the
/// normalisation of w.
///   state_noise   variance of x(t + period) - (the equations' step from x(t)), over the runs
///   output_noise  variance of y - h(x)
///   start         mean and variance of x at the start of segments. Uses the first samples of at least 16 runs if all
///                 segments begin there (`whole_runs`), else all samples. The variance is at least 1 % of the variance
///                 over all samples, so that a filter that starts again in flight finds the state
/// Unestimated states that no run has (`start_box`) begin in their box: its middle is the mean, half its width the
/// deviation. Their state_noise is 1e-4 of their variance.
/// If training adds noise to the sensors (`noisy`), the runs do not contain this noise. Then state_noise is 1e-4 of the
/// variance of x, and output_noise is the variance of y.
/// Throws codegen::Error if the equations have no bound within the range (codegen::check_bounded).
void start_prior(PriorSetting& own, const TrainingData& data);

}  // namespace nlo::trainer
