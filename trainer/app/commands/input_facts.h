// SPDX-License-Identifier: MIT
// What a model's provenance says of inputs, which the report and the exported header show: those that its observer is
// not given, and how old each must be when it is given in flight.
#pragma once

#include <string>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Their names, separated by commas; empty when the structure takes inputs or none are declared: [plant] inputs of
/// equations, or an [excitation] or a [feedback] of any plant.
std::string ignored_inputs(const Experiment& experiment);

/// Records them.
void record_ignored_inputs(const Experiment& experiment, codegen::Model& model);

/// One line for stderr about what the provenance says; empty when it says nothing.
std::string ignored_inputs_note(const codegen::Model& model);

/// Records [[log.columns]] delay_s of inputs that the model reads, in its samples; nothing where none is delayed.
void record_input_delays(const Experiment& experiment, codegen::Model& model);

}  // namespace nlo::trainer
