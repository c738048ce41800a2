// SPDX-License-Identifier: MIT
#pragma once

#include "codegen/model/model.h"
#include "trainer/data/dataset.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Sets model.flight: about 12,000 samples of the training data, in pieces that are spread over all runs. Half of the
/// pieces begin at the first sample of a run. Outputs have the noise of `rollout`, as the observer got them. A piece is
/// long compared with the slowest mode of the model's latent system. Short data is recorded whole. Each channel takes
/// about 20 KB.
void record_flight(codegen::Model& model, const Dataset& dataset, const Rollout& rollout);

}  // namespace nlo::trainer
