// SPDX-License-Identifier: MIT
// Values of the C99 templates for readings beside the outputs: known inputs, and sensors that may fail.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// Returns the values by name. If the model has neither, they are those of a model that only reads measurements.
std::map<std::string, std::string> c99_readings(const Model& model, const std::string& name, const Initialiser& init);

/// Returns the name of the constant for the size of a held sample, "kNy" or "kNr": the readings, then the inputs that
/// are not readings. The second function returns that for the readings of F and T*.
std::string c99_held_size(const Model& model);
std::string c99_readings_size(const Model& model);

/// Returns the number of inputs that act apart from the readings.
int acting_inputs(const Model& model);

/// Returns `rig_output_alpha, rig_output_load`.
std::string c99_positions(const std::string& prefix, const std::vector<Channel>& channels);

}  // namespace nlo::codegen
