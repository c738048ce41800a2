// SPDX-License-Identifier: MIT
// How old each input must be when it is given to a model in flight: said in its provenance, which the report and the
// exported header show.
#pragma once

#include "codegen/model/model.h"
#include "trainer/config/experiment.h"

namespace nlo::trainer {

/// Records [[log.columns]] delay_s of inputs that the model reads, in its samples; nothing where none is delayed.
void record_input_delays(const Experiment& experiment, codegen::Model& model);

}  // namespace nlo::trainer
