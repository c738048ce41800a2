// SPDX-License-Identifier: MIT
// EXPERIMENT on the command line: a file, or the name of an experiment in the program.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trainer/config/experiment.h"
#include "trainer/experiments/load_experiment.h"

namespace nlo::trainer {

struct ExperimentArgument {
  std::string experiment;              ///< path or name
  std::vector<std::string> overrides;  ///< --set
  std::optional<unsigned long long> seed;
  std::optional<int> threads;
};

/// Reads a draft. Throws codegen::Error like read_draft(); if there is no such file, it lists the shipped names.
DraftExperiment read_draft(const ExperimentArgument& argument);

/// Reads a complete experiment. Throws codegen::Error like read_experiment(); if there is no such file, it lists the
/// shipped names.
Experiment read_experiment(const ExperimentArgument& argument);

/// Returns the arguments of an `nlo` command about its experiment, quoted for a shell: EXPERIMENT --data DIR --set
/// KEY=VALUE --seed N. `data` may be empty. Threads are left out, because they change no result.
std::string command_words(const ExperimentArgument& argument, const std::string& data);

}  // namespace nlo::trainer
