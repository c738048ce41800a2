// SPDX-License-Identifier: MIT
// Logs begun in their middle: an observer may be switched on at any time, and most logs begin where it is easy.
#pragma once

#include <vector>

#include "trainer/data/dataset.h"

namespace nlo::trainer {

/// Each run once for each of `from_s` [s since its first sample]: from there to its end, with time and latent state
/// counted from there. A run that has not two samples left is left out. Throws codegen::Error when a start is negative
/// or beyond all runs.
Dataset started_at(const Dataset& logs, const std::vector<double>& from_s);

}  // namespace nlo::trainer
