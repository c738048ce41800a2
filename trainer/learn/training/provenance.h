// SPDX-License-Identifier: MIT
// Which run a model and a checkpoint belong to: the data and the experiment in a hash, and the facts a model keeps.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/data/dataset.h"
#include "trainer/learn/training/checkpoint.h"

namespace nlo::trainer {

/// Hash of a data set's numbers, on top of `hash`.
std::uint64_t data_fingerprint(const Dataset& dataset, std::uint64_t hash);

/// Hash of all data that a run trains on and chooses its model by: data_hash of a model's provenance.
std::uint64_t training_data_hash(const Dataset& training, const Dataset& validation);

/// 16 hex digits.
std::string hex_text(std::uint64_t value);

/// Hash of a run on data with that hash: of experiment and seed. A run may be resumed with another number of steps; any
/// other change makes it another run.
std::uint64_t run_fingerprint(const Experiment& experiment, std::uint64_t data_hash);

/// Name of the fact about inputs that the observer is not given.
inline constexpr const char* kIgnoredInputsFact = "ignored_inputs";

/// The origin of a model: version, seed, data, steps and error; name and text of each.
std::vector<std::pair<std::string, std::string>> run_facts(const Experiment& experiment, const Dataset& dataset,
                                                           std::uint64_t data_hash, const TrainingState& state,
                                                           double validation_rmse);

}  // namespace nlo::trainer
