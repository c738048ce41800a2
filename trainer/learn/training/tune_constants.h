// SPDX-License-Identifier: MIT
// Tunes the constants of a latent system before the first step of a training: the noise variances of a filter.
#pragma once

#include "trainer/base/parallel.h"
#include "trainer/config/experiment.h"
#include "trainer/rollout/training_data.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Sets the constants that the structure leaves to tuning (TrainableStructure::tuned_constants) by coordinate_search():
/// for the least RMSE of its estimate_row()s, with the noise of the training, on runs from their start and on segments
/// as a step of the training draws them. States count as in the loss: over their deviation if it is normalised. Long
/// data is tuned on a share of the runs. The result is the same for any number of threads.
void tune_constants(ObserverStructure& structure, const Experiment& experiment, const TrainingData& data,
                    ThreadPool& pool);

}  // namespace nlo::trainer
