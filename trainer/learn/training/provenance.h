// SPDX-License-Identifier: MIT
// Identifies the run of a model or a checkpoint: a hash of data and experiment, and the facts that a model stores.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {

/// Returns the hash of a data set's numbers, continued from `hash`.
std::uint64_t data_fingerprint(const Dataset& dataset, std::uint64_t hash);

/// Returns the hash of all data that trains the model and selects it: data_hash of a model's provenance.
std::uint64_t training_data_hash(const Dataset& training, const Dataset& validation);

/// Returns 16 hex digits.
std::string hex_text(std::uint64_t value);

/// Returns the hash of a run from experiment, seed and the hash of its data. A run may be resumed with another number
/// of steps; any other change makes it another run.
std::uint64_t run_fingerprint(const Experiment& experiment, std::uint64_t data_hash);

/// Name of the fact that lists inputs which the observer does not read.
inline constexpr const char* kIgnoredInputsFact = "ignored_inputs";

/// Returns name and text of each fact about the origin of a model: version, seed, data, steps and error.
std::vector<std::pair<std::string, std::string>> run_facts(const Experiment& experiment, const Dataset& dataset,
                                                           std::uint64_t data_hash, const TrainingState& state,
                                                           double validation_rmse);

}  // namespace nlo::trainer
