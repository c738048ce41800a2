// SPDX-License-Identifier: MIT
// Writes layers in int16 in C99: their tables and their evaluation.
#pragma once

#include <string>

#include "codegen/fold/quantise.h"

namespace nlo::codegen {

/// Returns the layers and activations of a step and of T*.
std::string c99_integer_arithmetic(const QuantisedModel& quantised);

/// Returns the tables of one layer, with these names and one neuron per line.
std::string c99_integer_tables(const QuantisedLayer& layer, const std::string& weights, const std::string& bias);

}  // namespace nlo::codegen
