// SPDX-License-Identifier: MIT
// What a C99 observer reads beside its outputs: the parts of its templates for known inputs, and for sensors that may
// fail.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "codegen/model/model.h"
#include "codegen/text/generated_text.h"

namespace nlo::codegen {

/// Values of the templates by name; nothing but a measurement is read where the model has neither.
std::map<std::string, std::string> c99_readings(const Model& model, const std::string& name, const Initialiser& init);

/// The constant that sizes what an observer holds of a sample, "kNy" or "kNr": the readings, and behind them the inputs
/// that act apart from those. And the one that sizes what F and T* read of it.
std::string c99_held_size(const Model& model);
std::string c99_readings_size(const Model& model);

/// How many inputs act apart from the readings.
int acting_inputs(const Model& model);

/// `rig_output_alpha, rig_output_load`
std::string c99_positions(const std::string& prefix, const std::vector<Channel>& channels);

}  // namespace nlo::codegen
