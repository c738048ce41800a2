// SPDX-License-Identifier: MIT
#pragma once

#include "codegen/model/model.h"
#include "trainer/data/dataset.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Sets model.flight: some 12,000 samples of the training data in pieces that are spread over all runs, half of them
/// from a run's first sample on, outputs with the noise of `rollout`, as the observer met them. Pieces are long against
/// the slowest mode of the model's latent system. Short data are recorded whole. Some 20 KB a channel.
void record_flight(codegen::Model& model, const Dataset& dataset, const Rollout& rollout);

}  // namespace nlo::trainer
