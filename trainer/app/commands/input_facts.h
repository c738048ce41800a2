// SPDX-License-Identifier: MIT
// Facts about inputs in a model's provenance, for the report and the exported header: the inputs that its observer is
// not given, and how old each must be in flight.
#pragma once

#include <string>

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Their names, separated by commas; empty when the structure takes inputs or none are declared: [plant] inputs of
/// equations, or an [excitation] or a [feedback] of any plant.
std::string ignored_inputs(const Experiment& experiment);

/// One line for stderr about the provenance; empty if there is nothing to say.
std::string ignored_inputs_note(const codegen::Model& model);

/// How old each input must be in flight, by [[log.columns]] delay_s, in samples; empty where none is delayed.
std::string input_delay(const LogConfig& log, double sample_period_s);

}  // namespace nlo::trainer
