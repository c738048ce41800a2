// SPDX-License-Identifier: MIT
// Gated units in place of a linear latent, where there is noise and no end of data: which of the two suits a plant,
// short trainings of both say.
#pragma once

#include <optional>

#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {

/// Turns `base`, the draft with the keys that decide its data, into a gated observer, complete and checked. Empty for
/// drafts that do not suit gated units: with logs, which are too few; without noise, because units lose accuracy to
/// keep noise out; with keys of [observer] for a linear latent system; with an angle that turns.
///   length_s  length of a run
std::optional<Experiment> gated_rival(const DraftExperiment& draft, const Experiment& base, double length_s);

}  // namespace nlo::trainer
