// SPDX-License-Identifier: MIT
// Where the training of an observer with a prior begins: ranges, scales, and noises by what the equations leave over.
#pragma once

#include "trainer/rollout/training_data.h"
#include "trainer/structures/prior_lanes.h"

namespace nlo::trainer {

/// Fills what of the setting is of the data: start, range, fine and coarse, noises, scales and the normalisation of w.
///   state_noise   the variance of x(t + period) - (the equations' step from x(t)), over the runs
///   output_noise  of y - h(x)
/// Where training adds noise to the sensors (`noisy`), which no run has: 1e-4 of the variance of x, and that of y.
void start_prior(PriorSetting& own, const TrainingData& data);

}  // namespace nlo::trainer
