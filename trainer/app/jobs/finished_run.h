// SPDX-License-Identifier: MIT
// finished.json, the last file of a training. It states that the run of this experiment on this data has ended with
// this model. A run that is killed earlier leaves no such file, or that of another model.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct FinishedRun {
  std::uint64_t experiment = 0;  ///< run_identity()
  std::uint64_t data = 0;        ///< hash of the logs; 0 for a plant, whose runs follow from the experiment
  std::string failure = {};  ///< reason not to trust the model: it diverged or did not improve its start; else empty
};

/// Returns a hash of the experiment, steps and seed included, before anything is derived from data.
std::uint64_t run_identity(const Experiment& experiment);

/// Writes DIR/finished.json next to its model.json. Throws codegen::Error if that fails.
void write_finished_run(const std::string& directory, const FinishedRun& run);

/// Returns nothing if no run has finished, or if model.json has changed since.
std::optional<FinishedRun> read_finished_run(const std::string& directory);

}  // namespace nlo::trainer
