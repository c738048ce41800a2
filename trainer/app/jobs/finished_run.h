// SPDX-License-Identifier: MIT
// finished.json, the last file that a training writes: the run of this experiment, on this data, came to its end and to
// this model. A run that is killed before leaves none, or that of another model.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "trainer/config/experiment.h"

namespace nlo::trainer {

struct FinishedRun {
  std::uint64_t experiment = 0;  ///< run_identity()
  std::uint64_t data = 0;        ///< hash of the logs; 0 of a plant, whose runs follow from the experiment
  std::string failure = {};      ///< why the model is not to be trusted: diverged, or got nowhere; else empty
};

/// Hash of all that an experiment says, steps and seed included, before anything is found out from data.
std::uint64_t run_identity(const Experiment& experiment);

/// Writes DIR/finished.json beside the model.json that it is about. Throws codegen::Error.
void write_finished_run(const std::string& directory, const FinishedRun& run);

/// Empty where no run has finished, or where model.json is no longer that of the run.
std::optional<FinishedRun> read_finished_run(const std::string& directory);

}  // namespace nlo::trainer
