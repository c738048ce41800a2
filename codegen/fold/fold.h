// SPDX-License-Identifier: MIT
// From a model to the numbers that fly.
#pragma once

#include <vector>

#include "codegen/model/folded.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

FoldedModel fold(const Model& model);

/// Measurements held in a row until the status says stale: one time constant of the fastest mode that reads an output,
/// 5 at least; 10 where no mode is known.
int stale_after(const Model& model);

/// For each reading, n_r: samples for which it is not due after one that has arrived; 0: due in every sample. A
/// computed output is as slow as the slowest of its parts.
std::vector<int> not_due(const Model& model);
/// The same for each of `outputs`, which may be computed from these and from `inputs`; then 0 for each input.
std::vector<int> not_due(const std::vector<Channel>& outputs, const std::vector<Channel>& inputs,
                         double sample_period_s);
/// Largest number of samples in a row that an output may be missing: a slow one may be late by half its period.
int most_missing(int not_due);
bool has_slow_outputs(const Model& model);

}  // namespace nlo::codegen
