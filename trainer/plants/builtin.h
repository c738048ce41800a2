// SPDX-License-Identifier: MIT
// The built-in plants, one file each. `parameters` are complete and in the order of the registry.
#pragma once

#include <memory>

#include "trainer/plants/plant.h"

namespace nlo::trainer {

std::unique_ptr<Plant> make_van_der_pol(const PlantParameters& parameters);
std::unique_ptr<Plant> make_reverse_duffing(const PlantParameters& parameters);
std::unique_ptr<Plant> make_sine_cosine(const PlantParameters& parameters);
std::unique_ptr<Plant> make_harmonic_oscillator(const PlantParameters& parameters);

}  // namespace nlo::trainer
