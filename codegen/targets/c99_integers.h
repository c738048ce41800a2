// SPDX-License-Identifier: MIT
// Layers in int16 in C99: their tables and their evaluation.
#pragma once

#include <string>

#include "codegen/fold/quantise.h"

namespace nlo::codegen {

/// Layers and their activations, of a step and of T*.
std::string c99_integer_arithmetic(const QuantisedModel& quantised);

/// The tables of one layer, by these names: one neuron per line.
std::string c99_integer_tables(const QuantisedLayer& layer, const std::string& weights, const std::string& bias);

}  // namespace nlo::codegen
