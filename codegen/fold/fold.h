// SPDX-License-Identifier: MIT
// Computes the numbers of an export from a model.
#pragma once

#include <vector>

#include "codegen/model/folded.h"
#include "codegen/model/model.h"

namespace nlo::codegen {

FoldedModel fold(const Model& model);

/// Returns the number of held measurements in a row after which the status is kStale: one time constant of the fastest
/// mode that reads an output, at least 5; 10 if no mode is known.
int stale_after(const Model& model);

/// Returns for each reading, n_r, the number of samples after an arrival in which it is not due; 0: due in every
/// sample. A computed output is as slow as the slowest of its parts.
std::vector<int> not_due(const Model& model);
/// As above for the channels `outputs`, which may be computed from each other and from `inputs`; then 0 for each input.
std::vector<int> not_due(const std::vector<Channel>& outputs, const std::vector<Channel>& inputs,
                         double sample_period_s);
/// Returns the largest number of samples in a row without an output: a slow output may be late by half its period.
int most_missing(int not_due);
bool has_slow_outputs(const Model& model);

}  // namespace nlo::codegen
