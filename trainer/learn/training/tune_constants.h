// SPDX-License-Identifier: MIT
// Tunes the constants of a latent system before the first step of a training, such as the noise variances of a filter.
#pragma once

#include "trainer/base/parallel.h"
#include "trainer/config/experiment.h"
#include "trainer/rollout/training_data.h"
#include "trainer/structures/observer_structure.h"

namespace nlo::trainer {

/// Sets the constants that the structure wants tuned (TrainableStructure::tuned_constants) by coordinate_search(). The
/// cost is the geometric mean of two RMSEs of its estimate_row()s, so that neither hides the other: over whole runs,
/// and over segments as a training step draws them, which may begin anywhere in a run. If the training uses whole runs,
/// the cost is the first RMSE. The data have the noise of the training. States are divided by their deviation if the
/// loss is normalised. If the data is long, only a share of its runs is used. The result is the same for any number of
/// threads.
void tune_constants(ObserverStructure& structure, const Experiment& experiment, const TrainingData& data,
                    ThreadPool& pool);

}  // namespace nlo::trainer
