// SPDX-License-Identifier: MIT
// All plants by name. A [plant] section names one of them or writes its own equations.
#pragma once

#include <memory>
#include <span>
#include <string_view>

#include "trainer/config/experiment.h"
#include "trainer/plants/plant.h"

namespace nlo::trainer {

struct PlantEntry {
  std::string_view name;
  std::string_view summary;    ///< one line for --help
  PlantParameters parameters;  ///< with their defaults
  std::unique_ptr<Plant> (*make)(const PlantParameters& complete);
};

std::span<const PlantEntry> plant_registry();

/// Makes the plant of a [plant] section: built-in, or by expressions when `model` is empty. Throws KeyError with the
/// key, the error and the nearest valid name.
std::unique_ptr<Plant> make_plant(const PlantConfig& config);

}  // namespace nlo::trainer
