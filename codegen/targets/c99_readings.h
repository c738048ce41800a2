// SPDX-License-Identifier: MIT
// Parts of the C99 templates for readings beside the outputs: known inputs, and sensors that may fail.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// Values of the templates by name; nothing but a measurement is read where the model has neither.
std::map<std::string, std::string> c99_readings(const Model& model, const std::string& name, const Initialiser& init);

/// Name of the constant that is the size of a held sample, "kNy" or "kNr": the readings, then the inputs that are no
/// readings. The second function names the size of the readings of F and T*.
std::string c99_held_size(const Model& model);
std::string c99_readings_size(const Model& model);

/// How many inputs act apart from the readings.
int acting_inputs(const Model& model);

/// `rig_output_alpha, rig_output_load`
std::string c99_positions(const std::string& prefix, const std::vector<Channel>& channels);

}  // namespace nlo::codegen
