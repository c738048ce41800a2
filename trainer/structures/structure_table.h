// SPDX-License-Identifier: MIT
// All observer structures by name.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/evaluation_windows.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

std::span<const TrainableStructure* const> structure_table();
std::vector<std::string> structure_names();

/// Returns the structure that [observer] names. An unknown name throws codegen::Error, which lists the known ones.
const TrainableStructure& structure_of(const ObserverConfig& observer);

/// Returns evaluation_windows() for an observer and runs of at most `horizon_s`. It ignores eigenvalues of a structure
/// without D: they are only initial values and do not give the speed of forgetting.
EvaluationWindows windows_of(const Experiment& experiment, double horizon_s);
}  // namespace nlo::trainer
