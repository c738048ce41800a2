// SPDX-License-Identifier: MIT
// How large the activations of T* get on the training data, for the scale of relu in integers.
#pragma once

#include "codegen/model/model.h"
#include "trainer/rollout/rollout.h"

namespace nlo::trainer {

/// Sets model.inverse_map.largest_activations, one number for each hidden layer, over the samples that count (some
/// 260,000 of them, evenly spread, where there are more). Nothing for tanh, which needs no record, and without T*.
void record_largest_activations(codegen::Model& model, const Rollout& rollout);

}  // namespace nlo::trainer
