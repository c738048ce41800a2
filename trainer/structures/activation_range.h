// SPDX-License-Identifier: MIT
// The ranges of the activations of T* on the training data. They determine the scale of relu in int16.
#pragma once

#include "codegen/model/model.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Sets model.inverse_map.largest_activations, one number for each hidden layer, over the samples that count. If there
/// are more than about 260,000, it uses that many, evenly spread. Does nothing for tanh, which needs no range, or if
/// there is no T*.
void record_largest_activations(codegen::Model& model, const Rollout& rollout);

}  // namespace nlo::trainer
