// SPDX-License-Identifier: MIT
// Derives the missing keys of an experiment from its plant or its logs. A file without eigenvalues is a draft
// (experiments/load_experiment.h), and all its keys are kept. Eigenvalues, features and the start are selected by
// measurement (readout_probe.h), and among the last few by short trainings (pilot.h). Rules derive the rest from sizes,
// time scales and the measurements.
#pragma once

#include <string>

#include "trainer/data/dataset.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {

/// Returns the draft with the keys that determine its training data: the number of trajectories, and whether mirror
/// images count as runs.
Experiment experiment_for_data(const DraftExperiment& draft);

struct Recipe {
  Experiment experiment;  ///< complete and checked; its source_text reads back to the same
  std::string text;       ///< text for users: the derived keys and the reasons, a line for each section
};

/// Derives the missing keys of `draft` from the data of experiment_for_data(). The same draft, seed and data give the
/// same experiment for any number of threads. Throws codegen::Error if no derived experiment fits the keys of the
/// draft.
Recipe derive_recipe(const DraftExperiment& draft, const Dataset& training, const Dataset& validation);

}  // namespace nlo::trainer
