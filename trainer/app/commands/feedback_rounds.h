// SPDX-License-Identifier: MIT
// The trainings of a run: one for each round of [feedback], or a single one without [feedback].
#pragma once

#include "trainer/app/commands/run_data.h"
#include "trainer/app/commands/run_folder.h"
#include "trainer/config/experiment.h"
#include "trainer/learn/training/train.h"

namespace nlo::trainer {

/// Options and messages of the trainings of a run.
struct RoundsOptions {
  bool resume = false;  ///< continue from the checkpoints in the run's folder
  bool quiet = false;   ///< no progress on stderr; warnings are printed anyway
  KnownFacts facts = {};
};

/// Trains round by round and returns the last training, which may be interrupted or diverged. At first, `data` has the
/// runs for round 0. Each round adds new runs to the training set in `data` and replaces the validation runs there.
TrainingResult run_rounds(const Experiment& experiment, RunData& data, const RunFolder& folder,
                          const RoundsOptions& options);

}  // namespace nlo::trainer
