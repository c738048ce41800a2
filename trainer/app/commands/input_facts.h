// SPDX-License-Identifier: MIT
// Facts about inputs in a model's provenance, for the report and the exported header: the inputs that its observer does
// not get, and the required delay of each input in flight.
#pragma once

#include <string>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Returns the names of the inputs that the observer does not get, separated by commas. Empty if the structure reads
/// inputs, or if there are no inputs: neither [plant] inputs of equations, nor an [excitation] or [feedback] of any
/// plant.
std::string ignored_inputs(const Experiment& experiment);

/// Returns one line for stderr about the provenance; may be empty.
std::string ignored_inputs_note(const codegen::Model& model);

/// Returns the required delay of each input in flight, by [[log.columns]] delay_s, in samples; empty if no input is
/// delayed.
std::string input_delay(const LogConfig& log, double sample_period_s);

}  // namespace nlo::trainer
