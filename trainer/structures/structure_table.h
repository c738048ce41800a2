// SPDX-License-Identifier: MIT
// All observer structures by name.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/structures/trainable_structure.h"

namespace nlo::trainer {

std::span<const TrainableStructure* const> structure_table();
std::vector<std::string> structure_names();

/// The structure that [observer] names. Throws codegen::Error listing the names that there are.
const TrainableStructure& structure_of(const ObserverConfig& observer);

}  // namespace nlo::trainer
