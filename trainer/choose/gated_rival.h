// SPDX-License-Identifier: MIT
// Gated units in place of a linear latent, where there is noise and no end of data: which of the two suits a plant,
// short trainings of both say.
#pragma once

#include <optional>

#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {

/// `base`, the draft with what decides its data, as a gated observer, complete and checked. Empty where that is none of
/// the draft's: logs, which are too few; no noise, which units keep out at the cost of accuracy; keys of [observer]
/// that a linear latent alone has; an angle that turns.
///   length_s  of a run
std::optional<Experiment> gated_rival(const DraftExperiment& draft, const Experiment& base, double length_s);

}  // namespace nlo::trainer
