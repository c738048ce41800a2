// SPDX-License-Identifier: MIT
// Inputs that an experiment declares and its observer is not given: said where a user would look for them.
#pragma once

#include <string>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Their names, separated by commas; empty when the structure takes inputs or none are declared: [plant] inputs of
/// equations, or an [excitation] or a [feedback] of any plant.
std::string ignored_inputs(const Experiment& experiment);

/// Records them in the model's provenance, which the report and the exported header show.
void record_ignored_inputs(const Experiment& experiment, codegen::Model& model);

/// One line for stderr about what the provenance says; empty when it says nothing.
std::string ignored_inputs_note(const codegen::Model& model);

}  // namespace nlo::trainer
