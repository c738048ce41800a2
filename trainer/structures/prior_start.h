// SPDX-License-Identifier: MIT
// The start of the training of an observer with a prior: ranges, scales, and noises from the residuals of the
// equations.
#pragma once

#include "trainer/rollout/training_data.h"
#include "trainer/structures/prior_lanes.h"

namespace nlo::trainer {

/// Fills the parts of the setting that come from data: start, range, fine and coarse, noises, scales and the
/// normalisation of w.
///   state_noise   the variance of x(t + period) - (the equations' step from x(t)), over the runs
///   output_noise  the variance of y - h(x)
/// If training adds noise to the sensors (`noisy`), which the runs lack: 1e-4 of the variance of x, and the variance
/// of y.
///   start         mean and variance of x where segments begin: at the first samples if these are all `whole_runs`,
///                 and there are 16 runs at least; else at any sample. At least 1 % of the variance at any sample, so
///                 that a filter that starts again in flight finds the state.
/// Throws codegen::Error if the equations have no bound within the range (codegen::check_bounded).
void start_prior(PriorSetting& own, const TrainingData& data);

}  // namespace nlo::trainer
