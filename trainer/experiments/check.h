// SPDX-License-Identifier: MIT
// What the keys of an experiment must satisfy together: sizes that agree, sections that exclude each other, a latent
// system that is stable at the sample period, angles that the observer can turn with.
#pragma once

#include "trainer/config/experiment.h"
#include "trainer/config/places.h"

namespace nlo::trainer {

/// Throws codegen::Error `FILE:LINE: what is wrong; what to do`.
void check_experiment(const Experiment& experiment, const Places& places);

}  // namespace nlo::trainer
